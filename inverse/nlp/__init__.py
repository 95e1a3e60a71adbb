"""A sparse nonlinear program from mapped kernels, and a point of it; no geometry."""
