"""One bird behind another: the follower's problem, posed and solved."""

from __future__ import annotations

from upwash.aero.bird import Bird
from upwash.aero.pose import Stroke
from upwash.aero.wake import WakeModel
from upwash.optimum.cut_problem import ending_problems
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.solve import solve_endless_pair
from upwash.optimum.pieces import solve_pieces
from upwash.optimum.problem import PairProblem
from upwash.optimum.settings import SearchSettings
from upwash.optimum.solution import PairSolution
from upwash.optimum.solvable import need_solvable
from upwash.optimum.spacing import FREE, Spacing

PAPER = WakeModel()


def solve_pair(
    bird: Bird,
    objective: str = "force",
    *,
    ahead: Stroke | None = None,
    amplitude_limit_m: float | None = None,
    model: WakeModel | None = None,
    search: SearchSettings | None = None,
    distance_m: float | None = None,
    leader: Bird | None = None,
    phase_lock: bool = True,
    spacing: Spacing | None = None,
) -> PairSolution:
    """Find where and how a follower should fly behind a leader, with all other optima, and prove the best.

    Parameters
    ----------
    bird : Bird
        The follower, as it flies alone; what it then spends is what savings are shares of.
    objective : str
        Name of a cost function.
    ahead : Stroke, optional
        How the bird immediately ahead flaps; as that bird does alone if not given.
    amplitude_limit_m : float, optional
        Largest amplitude of the follower; if not given its own, or the share of it that the bird ahead has of its own.
    model : WakeModel, optional
        Resolution of the wake: two stroke states and a wake that ends, or an endless wake and the exact span.
    search : SearchSettings, optional
        How long to search, and how closely to prove.
    distance_m : float, optional
        How far behind the leader the follower of an endless wake is said to fly, half a wavelength if not given: the
        phase follows from it, and nothing else.
    leader : Bird, optional
        The bird ahead, at the same speed and in the same air; like the follower if not given.
    phase_lock : bool
        Whether the follower beats in step with its leader, in its period and at the best phase; else it keeps its own
        period, and the force of the wake is averaged over all phases.
    spacing : Spacing, optional
        What the follower keeps to: limits of its place beside the paper's bounds.

    Returns
    -------
    PairSolution
        The optima, best first, and the proof.

    Raises
    ------
    ValueError
        If an input is out of range; the message names it.

    Examples
    --------
    >>> from upwash import load_species
    >>> best = solve_pair(load_species("northern-bald-ibis").bird(), "force").v_optimum
    >>> print(f"{best.x_m:.2f} m behind and {best.y_m:.2f} m aside it saves {best.saving_total:.0%} of its power")
    1.82 m behind and 0.88 m aside it saves 11% of its power
    """
    problems = pair_problems(
        bird,
        objective,
        ahead,
        amplitude_limit_m,
        model or WakeModel(),
        distance_m,
        leader=leader,
        phase_lock=phase_lock,
        spacing=spacing,
    )
    settings = search or SearchSettings()
    if isinstance(problems[0], EndlessProblem):
        return solve_endless_pair(problems[0], settings)
    return solve_pieces(problems, settings)


def pair_problems(
    bird: Bird,
    objective: str,
    ahead: Stroke | None = None,
    amplitude_limit_m: float | None = None,
    model: WakeModel = PAPER,
    distance_m: float | None = None,
    *,
    leader: Bird | None = None,
    phase_lock: bool = True,
    spacing: Spacing | None = None,
) -> list[PairProblem]:
    """Pose a pair's problem, in each piece of its phase; parameters and errors are those of `solve_pair`."""
    need_solvable(model)
    # None stands for the bird's own: the problem puts it in.
    if model.is_endless:
        endless = EndlessProblem(
            bird,
            objective,
            ahead,  # type: ignore[arg-type]
            amplitude_limit_m,  # type: ignore[arg-type]
            model,
            leader=leader,  # type: ignore[arg-type]
            phase_lock=phase_lock,
            distance_m=distance_m,
            spacing=spacing or FREE,
        )
        return [endless]
    if distance_m is not None:
        raise ValueError(
            f"distance_m: expected none, as behind a wake that ends the distance is found, found {distance_m!r}"
        )
    return ending_problems(
        bird,
        objective,
        ahead,
        amplitude_limit_m,
        model,
        leader=leader,
        phase_lock=phase_lock,
        spacing=spacing or FREE,
    )
