"""A core edge by its parts: which point of the follower's wing rides the core of which vortex.

In the results it is written as these parts with a stroke between each two, several edges with commas, so that a
program can take them apart again; for people they are put into words.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace

BOTH = "both"
"""Both wingtips: they are as far from a spanwise filament."""

TURN = "turn"
"""The spanwise filament that an endless wake has where a stroke ends."""

SIDES = {"left": "right", "right": "left", "left tip": "right tip", "right tip": "left tip"}


@dataclass(frozen=True)
class CoreEdge:
    """Where a point of the follower's wing, in one of its states, is a core's radius from a filament.

    Parameters
    ----------
    point : str
        ``left`` or ``right`` wingtip, `BOTH`, or the place of a span node from -1 (left tip) to 1.
    state : str
        The follower's: ``up``, ``down``, or its height over its amplitude and, behind an endless wake, its way.
    filament : str
        ``starting``, ``stopping``, ``left tip`` or ``right tip`` of a ring, or `TURN`.
    ring : str
        ``upstroke`` or ``downstroke``, the one that ends at a turn.
    shed : str
        State of the bird that shed the ring: ``up``, ``down``, or its number; of a turn, how far downstream of the
        leader it is, in wavelengths.
    row : str
        That bird's row, if it is not the one that is followed.

    Examples
    --------
    >>> edge = CoreEdge("left", "down", "right tip", "upstroke", "up")
    >>> str(edge)
    'left/down/right tip/upstroke/up'
    >>> CoreEdge.of(str(edge)) == edge
    True
    >>> print(edge.mirrored())
    right/down/left tip/upstroke/up
    """

    point: str
    state: str
    filament: str
    ring: str
    shed: str
    row: str = ""

    def __str__(self) -> str:
        return "/".join(astuple(self)).rstrip("/")

    @classmethod
    def of(cls, text: str) -> CoreEdge:
        """Return the edge that a text of the results means."""
        return cls(*text.split("/"))

    def mirrored(self) -> CoreEdge:
        """Return the edge on the other side of the bird ahead."""
        point = SIDES.get(self.point, self.point)
        if point[0] in "+-":
            point = f"{0.0 - float(point):+.3g}"
        return replace(self, point=point, filament=SIDES.get(self.filament, self.filament))


def edges_in(text: str) -> tuple[CoreEdge, ...]:
    """Return the edges that a row of the results names.

    Examples
    --------
    >>> [edge.filament for edge in edges_in("both/down/stopping/upstroke/up, left/down/right tip/upstroke/up")]
    ['stopping', 'right tip']
    """
    return tuple(CoreEdge.of(part) for part in text.split(", ")) if text else ()


def other_side(text: str) -> str:
    """Return the edges that a row names as they are on the other side of the bird ahead."""
    return ", ".join(str(edge.mirrored()) for edge in edges_in(text))
