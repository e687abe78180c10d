"""Finding the best: the scaled problem, local solves, the search and its proof, flocks."""

from pipeline.optimum.flock import solve_flock
from pipeline.optimum.flock_solution import FlockSolution
from pipeline.optimum.joint import JointSolution, improve_together
from pipeline.optimum.pair import solve_pair
from pipeline.optimum.rotation import take_turns
from pipeline.optimum.solution import Optimum, PairSolution, Proof

__all__ = [
    "FlockSolution",
    "JointSolution",
    "Optimum",
    "PairSolution",
    "Proof",
    "improve_together",
    "solve_flock",
    "solve_pair",
    "take_turns",
]
