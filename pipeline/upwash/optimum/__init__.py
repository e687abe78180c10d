"""Finding the best: the scaled problem, local solves, the search and its proof, flocks."""

from upwash.optimum.flock import solve_flock
from upwash.optimum.flock_solution import FlockSolution
from upwash.optimum.joint import JointSolution, improve_together
from upwash.optimum.pair import solve_pair
from upwash.optimum.rotation import take_turns
from upwash.optimum.solution import Optimum, PairSolution, Proof

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
