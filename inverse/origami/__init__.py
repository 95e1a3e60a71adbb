"""A mesh, its seeds and its motion."""
