"""``python -m inverse``."""

from inverse.cli import main

main()
