"""What may be chosen of a search and of a flock."""

from __future__ import annotations

from dataclasses import dataclass, field

from upwash.aero.checked import check_fields, fraction, must_be, one_of, whole_from, within

SHAPES = ("echelon", "vee", "alternating")
"""One line to the right; two lines from one leader; one line that turns to the other side at each bird."""

WAKES = ("neighbour", "all-upstream")
"""Whose wakes a bird feels: that of the bird it follows, or of every bird in a row ahead."""

READINGS = ("immediate", "lone")
"""Whose amplitude bounds a follower's: that of the bird it follows, or of a bird flying alone."""

# What Parquet and TOML keep of whole numbers.
_SEED = whole_from(0, 2**63 - 1, "a file keeps 64 bits")
_COUNT = whole_from(1, 10**9, "more would not end")
_GAP = fraction & within(1e-12, 1.0, "costs are rounded to that")

BIRDS = whole_from(2, 1000, "each takes a search of its own, and no line of birds is longer")
"""What the number of birds in a flock must be."""


FLOCK_CHOICES = {"shape": SHAPES, "wake": WAKES, "reading": READINGS}
"""What a flock's shape, wake and reading of the amplitude bound may be."""


@dataclass(frozen=True)
class SearchSettings:
    """How long to search, and how closely to prove.

    Parameters
    ----------
    seed : int
        Seed of the random starts.
    tolerance : float
        Relative gap to which the best is to be proved, between 0 and 1.
    starts : int
        Random starts in each kind of place (outboard or inboard, astern or abreast) and, again, in the V region;
        the search around the best optima adds to them.
    most_boxes : int
        Budget of boxes of each proof.

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.

    Examples
    --------
    >>> SearchSettings(seed=7).tolerance
    0.0001
    """

    seed: int = field(default=0, metadata=must_be(_SEED))
    tolerance: float = field(default=1e-4, metadata=must_be(_GAP))
    starts: int = field(default=120, metadata=must_be(_COUNT))
    most_boxes: int = field(default=2_000_000, metadata=must_be(_COUNT))

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class FlockRules:
    """How a flock is built.

    Parameters
    ----------
    shape : str
        One of `SHAPES`.
    wake : str
        Whose wakes a bird feels, one of `WAKES`.
    reading : str
        Whose amplitude bounds a follower's, one of `READINGS`.

    Raises
    ------
    ValueError
        If a choice is unknown; the message names it.

    Examples
    --------
    >>> rules = FlockRules("vee", wake="all-upstream")
    >>> [rules.leader_of(number) for number in range(2, 7)]
    [1, 1, 2, 3, 4]
    >>> rules.felt_by(4)
    [1, 3, 2]
    """

    shape: str = field(default="echelon", metadata=must_be(one_of(SHAPES)))
    wake: str = field(default="neighbour", metadata=must_be(one_of(WAKES)))
    reading: str = field(default="immediate", metadata=must_be(one_of(READINGS)))

    def __post_init__(self) -> None:
        check_fields(self)

    def leader_of(self, number: int) -> int:
        """Return the number of the bird that a bird follows."""
        return max(1, number - 2) if self.shape == "vee" else number - 1

    def side_of(self, number: int) -> float:
        """Return the side of its leader on which a bird flies: 1 right, −1 left."""
        return -1.0 if self.shape != "echelon" and number % 2 else 1.0

    def row_of(self, number: int) -> int:
        """Return how many birds of its own line fly ahead of a bird."""
        return number // 2 if self.shape == "vee" else number - 1

    def felt_by(self, number: int) -> list[int]:
        """Return the numbers of the birds whose wakes a bird feels, the one that it follows last.

        Of the others those on the bird's own side come before those on the other, so that the order mirrors as
        the birds do.
        """
        leader = self.leader_of(number)
        if self.wake == "neighbour":
            return [leader]
        ahead = [one for one in range(1, number) if self.row_of(one) < self.row_of(number) and one != leader]
        return [*sorted(ahead, key=lambda one: (self.row_of(one), (one - number) % 2)), leader]
