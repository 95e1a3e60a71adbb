"""One run of a solver on one program."""
