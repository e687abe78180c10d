"""The physics, tested against the paper, the laws it rests on, and independent numbers."""
