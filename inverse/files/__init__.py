"""What is read and written whole."""
