"""What may be chosen of how a table is read: names alone, so that commands can print them at once."""

from __future__ import annotations

import math

PHASE_UNITS = {"beats": 1.0, "deg": 1.0 / 360.0, "rad": 0.5 / math.pi}
"""Units in which a phase may stand, in wingbeats."""

PHASE_SIGNS = ("lag", "lead")
"""Whether a positive phase says that the follower comes later than its leader, or earlier."""

PHASE_STARTS = {"downstroke-start": 0.0, "upstroke-start": 0.5}
"""Where a bird's own wingbeat may begin, in wingbeats after the start of its downstroke."""
