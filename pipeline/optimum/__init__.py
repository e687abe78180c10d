"""Finding the best: the scaled problem, local solves, the search and its proof, flocks."""

from pipeline.optimum.pair import solve_pair
from pipeline.optimum.solution import Optimum, PairSolution, Proof

__all__ = ["Optimum", "PairSolution", "Proof", "solve_pair"]
