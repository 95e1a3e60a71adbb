"""A sparse nonlinear program from mapped kernels; no geometry."""
