"""Whether a design is what was asked: measures of the design itself, compared with the specification."""
