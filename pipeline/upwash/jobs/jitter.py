"""What a job tells of a follower whose place jitters: what its best place leaves, and which place leaves most."""

from __future__ import annotations

from typing import TYPE_CHECKING

from upwash import columns as of
from upwash.aero.checked import WrongInput, positive, within
from upwash.aero.pose import Pose, Stroke
from upwash.jobs.stored import Complaints

if TYPE_CHECKING:
    from upwash.aero.bird import Bird
    from upwash.jobs.job import Job
    from upwash.place.robust import Jittering

SIGMA = "position_sigma_ratio"
"""The input: standard deviation of the place in each of x, y and z, in semispans."""

RULE = positive & within(1e-4, 1.0, "beyond, nothing is left of any place")

STILL, SAVING, PLACE = "robust_saving_still", "robust_saving", "robust_"
"""What the still optimum leaves; what the place leaves that leaves most; that place."""

POSE = ("x_m", "y_m", "z_m", "phase", "amplitude_m", "upstroke_span_ratio")

NAMES = (STILL, SAVING, *(PLACE + name for name in POSE))
"""All columns of it."""

AGREES = of.Agreement(relative=1e-7, absolute=1e-9)
"""How closely means over the same draws must agree that are computed anew."""


def need_alike(job: Job) -> None:
    """Refuse a jitter where it is not told what it leaves.

    Raises
    ------
    ValueError
        If birds are unlike or beat out of step, or keep to limits, or the job is no pair.
    """
    if job.position_sigma_ratio is None:
        return
    kind = job.kind.inputs()
    if (
        job.kind.name != "pair"
        or kind.get("ahead_species")
        or not kind.get("phase_lock")
        or job.spacing.names
    ):
        expected = "none but for a pair of like birds that beat in step and keep to no limits"
        raise WrongInput(SIGMA, expected, job.position_sigma_ratio)


def left_by_jitter(job: Job, bird: Bird, still: Pose, in_v: bool) -> of.Row:
    """Return what a job tells of a follower whose place jitters, by column; nothing if that was not asked.

    Parameters
    ----------
    job : Job
        The job.
    bird : Bird
        Its bird.
    still : Pose
        The best place at rest.
    in_v : bool
        Whether that is in a V, where the other is then sought too.
    """
    if job.position_sigma_ratio is None:
        return {}
    jittering = _jittering(job, bird)
    found: of.Row = {STILL: jittering.held(still)[1]}
    best = jittering.best([still], in_v=in_v)
    if best is not None and best.pose is not None:
        found |= _columns(best.pose) | {SAVING: best.saving_held}
    return found


def unlike_left(job: Job, bird: Bird, row: of.Stored, still: Pose, in_v: bool) -> Complaints:
    """Give what of a job's row does not hold of a follower whose place jitters; parameters as for `left_by_jitter`."""
    if job.position_sigma_ratio is None:
        for name in NAMES:
            if row.get(name) is not None:
                yield name, f"expected none, as no jitter was asked for, found {row[name]}"
        return
    expected: of.Row
    values = {name: row[PLACE + name] for name in POSE}
    if any(value is None for value in values.values()):
        expected = left_by_jitter(job, bird, still, in_v)
    else:
        jittering = _jittering(job, bird)
        stroke = Stroke(values["amplitude_m"], values["upstroke_span_ratio"])
        told = Pose(values["x_m"], values["y_m"], values["z_m"], stroke, values["phase"])
        pose, saving = jittering.held(told)
        expected = {STILL: jittering.held(still)[1], SAVING: saving}
        expected |= _columns(pose) if pose else {}
    for name in NAMES:
        value, found = expected.get(name), row[name]
        if (value is None) != (found is None) or (
            value is not None and not AGREES.holds(float(value), float(found))
        ):
            yield name, f"expected {value} over the places of its jitter, found {found}"


def _jittering(job: Job, bird: Bird) -> Jittering:
    from upwash.place.balance import Behind
    from upwash.place.robust import Jittering, Spread

    assert job.position_sigma_ratio is not None
    behind = Behind(bird, job.objective, model=job.model)
    return Jittering(behind, Spread.of_place(job.position_sigma_ratio * bird.semispan_m))


def _columns(pose: Pose) -> of.Row:
    stroke = {
        "amplitude_m": pose.stroke.amplitude_m,
        "upstroke_span_ratio": pose.stroke.span_ratio,
    }
    place: of.Row = {name: getattr(pose, name) for name in ("x_m", "y_m", "z_m", "phase")}
    return {PLACE + name: value for name, value in (place | stroke).items()}
