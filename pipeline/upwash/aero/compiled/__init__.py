"""Kernels of the physics: everything here is compiled."""
