"""From what is asked to terms."""
