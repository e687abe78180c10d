"""The search and its proof, tested on the paper's pair, on laws of the problem, and by other methods."""
