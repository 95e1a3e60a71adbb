"""The motion as films and pages."""
