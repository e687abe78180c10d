"""Two birds that fly together and need not be alike: what they share, and in whose beat the follower flies.

The bird ahead sheds the wake: its circulation, semispan, stroke, wavelength and core are its own.  The follower has its
own weight, drag, span and circulation.  Airspeed, air and gravity are those of both.
"""

from __future__ import annotations

from dataclasses import replace

from upwash.aero.bird import Bird
from upwash.aero.checked import WrongInput

SHARED = ("speed_m_s", "density_kg_m3", "gravity_m_s2")
"""Inputs that are the same for birds that fly together."""


def need_shared(bird: Bird, leader: Bird) -> None:
    """Refuse birds that cannot fly together.

    Raises
    ------
    ValueError
        If they fly at different speeds, or in different air; the message names the leader's input.
    """
    for name in SHARED:
        own, found = getattr(bird, name), getattr(leader, name)
        if own != found:
            raise WrongInput(f"leader's {name}", f"the follower's, {own:g}, as they fly together", found)


def in_step(bird: Bird, leader: Bird, phase_lock: bool) -> Bird:
    """Return a follower as it beats: with a locked phase in its leader's period, else in its own.

    Weight and circulation are as before; what it calls its drag there is the thrust of its lone stroke in that period.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from upwash import load_species
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> slow = replace(ibis, period_s=0.5)
    >>> in_step(ibis, slow, True).period_s, in_step(ibis, slow, False) is ibis, in_step(ibis, ibis, True) is ibis
    (0.5, True, True)
    """
    if not phase_lock or bird.period_s == leader.period_s:
        return bird
    return replace(bird, period_s=leader.period_s)
