"""Whose speed two unlike birds fly at, and which speed a bird chooses: words that commands know without the physics."""

FOLLOWERS, LEADERS, MEAN = "follower", "leader", "mean"
SPEEDS = (FOLLOWERS, LEADERS, MEAN)
"""One bird's own, or the mean of the two."""

OWN, LEAST_POWER, LEAST_TRANSPORT = "own", "least-power", "least-transport"
CHOSEN = (OWN, LEAST_POWER, LEAST_TRANSPORT)
"""The speed of a bird: its species' own, or that at which it spends least alone, for a time or for a distance."""
