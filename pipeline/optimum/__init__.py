"""Finding the best: the scaled problem, local solves, the global search, its proof, flocks."""
