"""Terms of the program that are too large for constraints.py and objectives.py."""
