"""Thick panels."""
