"""What may be chosen of a place and of a stroke there: names alone, so that commands can print them at once."""

from __future__ import annotations

BOUNDS = ("paper", "wide")
"""Within which bounds a stroke is sought: those of the paper's search, or as wide as a wing may move."""

COORDINATES = ("x", "y", "z", "phase")
"""What a place consists of: behind the leader, to the right of it, above it, and the lag in wingbeats."""

PLANES = {"xy": ("x", "y"), "xz": ("x", "z"), "yz": ("y", "z"), "xk": ("x", "phase")}
"""Planes of places -> the coordinates along their two sides."""

STROKE = "stroke"
"""How a follower flaps, which follows at each place from what balances there."""
