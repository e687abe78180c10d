"""Finding the best place behind an endless wake: the problem, its search, what speaks for an optimum, and the proof."""
