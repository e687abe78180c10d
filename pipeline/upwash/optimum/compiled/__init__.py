"""Kernels of search and proof: everything here is compiled."""
