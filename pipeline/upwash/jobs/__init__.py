"""What one job is: its inputs and its id, its kind, how it is solved, and what must hold of its rows.

The border between the physics and the files: above it nobody asks what a job computes.
"""
