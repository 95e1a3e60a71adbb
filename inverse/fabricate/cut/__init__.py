"""Crease patterns to cut."""
