"""Whose speed two birds that are not alike fly at; by itself, so that a command knows the words without the physics."""

FOLLOWERS, LEADERS, MEAN = "follower", "leader", "mean"
SPEEDS = (FOLLOWERS, LEADERS, MEAN)
"""One bird's own, or the mean of the two."""
