"""What is built from a design: thick panels, their motion and contacts, and files for other programs."""
