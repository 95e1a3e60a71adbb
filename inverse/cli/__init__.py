"""The command line: human words on stderr, results on stdout."""
