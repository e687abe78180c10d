"""Finding the best: the scaled problem, local solves, the search and its proof, flocks."""
