"""Drawings as architects make them: plan, elevations, section, axonometric and motion, to scale on paper."""
