"""What may vary of a follower: one table of the six variables of the scaled problem.

Lengths are in the follower's semispans.  The order is that of every point, bound and slope: position x, y, z, amplitude
h, upstroke span ratio R, and the phase coordinate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.endless import LEAST_PHASE, MOST_PHASE

STREAMWISE_REACH = 1.5
"""Far bound of x_F − x_L in wavelengths; the paper states none."""

SPANWISE_REACH = 4.0
"""Far bound of y_F − y_L in semispans of the wider bird; the paper states none."""

LEAST_AMPLITUDE = 0.25
"""Least amplitude of the follower over the limit above."""

SPAN_RATIO_BOUNDS = (0.3, 0.5)
"""Bounds of the follower's upstroke span ratio."""


class Box(NamedTuple):
    """Within which x and y a follower keeps for its own reasons.

    Attributes
    ----------
    least_x, least_y, most_y : float
        Where nothing limits them: 0, 0 and infinite.
    """

    least_x: float
    least_y: float
    most_y: float


class Given(NamedTuple):
    """What the bounds of the variables depend on.

    Attributes
    ----------
    wavelength : float
        Wavelength.
    amplitude_ahead : float
        Amplitude of the bird ahead.
    amplitude_limit : float
        Largest amplitude of the follower.
    phase_span : float
        Greatest phase coordinate.
    widest : float
        Semispan of the wider of the two birds.
    box : Box
        Within which a follower keeps, in semispans.
    """

    wavelength: float
    amplitude_ahead: float
    amplitude_limit: float
    phase_span: float
    widest: float = 1.0
    box: Box = Box(0.0, 0.0, math.inf)


Bounds = Callable[[Given], tuple[float, float]]


class Variable(NamedTuple):
    """One variable.

    Attributes
    ----------
    name : str
        As it appears in `active_bounds`.
    scale : float
        How far it may change while the others change by their own: the variables then matter alike.
    neighbourhood : float
        How far around a basin starts are drawn; infinite where they are drawn over all of its range.
    bounds : callable
        Its least and its greatest value, by what they depend on.
    """

    name: str
    scale: float
    neighbourhood: float
    bounds: Bounds


TABLE = (
    Variable("x", 0.3, 0.5, lambda given: (given.box.least_x, STREAMWISE_REACH * given.wavelength)),
    Variable(
        "y", 0.3, 0.5, lambda given: (given.box.least_y, min(SPANWISE_REACH * given.widest, given.box.most_y))
    ),
    Variable("z", 0.3, 0.5, lambda given: (-given.amplitude_ahead, given.amplitude_ahead)),
    Variable("h", 0.3, 0.5, lambda given: (LEAST_AMPLITUDE * given.amplitude_limit, given.amplitude_limit)),
    Variable("R", 0.1, 0.1, lambda given: SPAN_RATIO_BOUNDS),
    Variable("mu", 0.25, math.inf, lambda given: (0.0, given.phase_span)),
)
"""Behind a wake that ends."""

_X, _Y, _Z, _H, _R, _MU = TABLE
ENDLESS_TABLE = (
    _X._replace(bounds=lambda given: (LEAST_PHASE * given.wavelength, MOST_PHASE * given.wavelength)),
    _Y._replace(neighbourhood=0.3),
    _Z._replace(neighbourhood=0.3),
    _H._replace(neighbourhood=0.3),
    _R._replace(neighbourhood=0.05),
    _MU._replace(neighbourhood=0.0, bounds=lambda given: (0.0, 0.0)),
)
"""Behind an endless wake: x is X = λΦ, the place in the frozen wake, and takes the place of the phase as well."""

AVERAGED_TABLE = (
    ENDLESS_TABLE[0]._replace(neighbourhood=0.0, bounds=lambda given: (0.0, 0.0)),
    *ENDLESS_TABLE[1:],
)
"""The same where the force is averaged over all phases, and with them over all X."""

VARIABLE_COUNT = len(TABLE)

VARIABLES = tuple(each.name for each in TABLE)
"""Their names, in order."""

SCALE = np.array([each.scale for each in TABLE])
"""Their scales, in order; the trust region of a local solve is a box of this shape."""


def bounds_of(table: Sequence[Variable], given: Given) -> NDArray[np.float64]:
    """Return the bounds of all variables of a table.

    Parameters
    ----------
    table : sequence of Variable
        The variables.
    given : Given
        What the bounds depend on.

    Returns
    -------
    (6, 2) ndarray of float
        The least and the greatest value of each.

    Examples
    --------
    >>> bounds_of(TABLE, Given(6.25, 1.7, 1.6, 0.5))[3].tolist()
    [0.4, 1.6]
    """
    return np.array([each.bounds(given) for each in table])


def neighbourhood_of(table: Sequence[Variable]) -> NDArray[np.float64]:
    """Return how far around a basin starts are drawn, variable by variable."""
    return np.array([each.neighbourhood for each in table])
