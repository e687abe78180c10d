"""Solvers of the tests' own, which cost next to nothing and go wrong on demand.

Worker processes import them by the name that a sweep file gives: ``solver = "stub_solvers:…"``. What they did
is told by lines appended to the file that the environment names.
"""

import errno
import os
import signal
import time
from pathlib import Path

LOG = "UPWASH_TEST_LOG"


def log(text):
    if LOG in os.environ:
        descriptor = os.open(os.environ[LOG], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(descriptor, f"{text}\n".encode())
        os.close(descriptor)


def is_fixed():
    return Path(os.environ.get("UPWASH_TEST_FIXED", "/nonexistent")).exists()


def row(job, rank=0, **more):
    """A solution that passes every check of its form; its figures mean nothing."""
    return {
        "cost": 10.0 + job.mass_kg + rank,
        "rank": rank,
        "is_v_optimum": rank == 1,
        "is_global_optimum": rank == 0,
        "solve_time_s": 0.001,
    } | more


def trivial(job):
    return "solved", "", [row(job)]


def two_optima(job):
    log(job.job_id)
    return "solved", "", [row(job, 0), row(job, 1)]


def slow(job):
    log(job.job_id)
    time.sleep(0.02)
    return "solved", "", [row(job, 0), row(job, 1)]


def told_at_both_ends(job):
    log(f"begun:{job.job_id}")
    time.sleep(0.2)
    log(f"ended:{job.job_id}")
    return "solved", "", [row(job)]


def waiting_when_heavy(job):
    """Wait, beyond 1.25 kg, until the test lets go; a minute at most."""
    log(job.job_id)
    for _ in range(6000):
        if job.mass_kg <= 1.25 or is_fixed():
            break
        time.sleep(0.01)
    return "solved", "", [row(job, 0), row(job, 1)]


def failing_when_heavy(job):
    """Fail beyond 1.25 kg, unless a file says that the fault is fixed."""
    log(job.job_id)
    if job.mass_kg > 1.25 and not is_fixed():
        raise ZeroDivisionError("a bird too heavy,\nover two lines")
    return "solved", "", [row(job)]


def infeasible(job):
    return "infeasible", "nowhere to fly", []


def failing_or_infeasible(job):
    """Fail beyond 1.25 kg; below it there is nowhere to fly."""
    return failing_when_heavy(job) if job.mass_kg > 1.25 else infeasible(job)


def suicidal_when_heavy(job):
    """Kill the worker, as the system does when memory runs out."""
    log(job.job_id)
    if job.mass_kg > 1.25:
        os.kill(os.getpid(), signal.SIGKILL)
    return "solved", "", [row(job)]


def suicidal_once(job):
    """Kill the worker the first time that the heavy bird is met."""
    log(job.job_id)
    marker = Path(os.environ[LOG] + ".killed")
    if job.mass_kg > 1.25 and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "solved", "", [row(job)]


def exiting(job):
    raise SystemExit(3)


def unknown_column(job):
    return "solved", "", [row(job, wingspan_in_feet=4.0)]


def wrong_type(job):
    return "solved", "", [row(job, hits="many")]


def endless(job):
    return "solved", "", [row(job, v_lower_bound=float("inf"), stationarity=float("nan"))]


def threads(job):
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        log(f"{name}={os.environ.get(name)}")
    return trivial(job)


def unknown_column_when_heavy(job):
    return "solved", "", [row(job, **{"wingspan_in_feet": 4.0} if job.mass_kg > 1.25 else {})]


def mixed(job):
    """Be solved below 1.2 kg, infeasible below 1.3 kg, and fail beyond, unless the fault is fixed."""
    log(job.job_id)
    if 1.2 <= job.mass_kg < 1.3:
        return "infeasible", "nowhere to fly", []
    if job.mass_kg >= 1.3 and not is_fixed():
        raise ZeroDivisionError("a bird too heavy")
    return "solved", "", [row(job)]


def lasting(job):
    """Go on once as many jobs are at work as a file says, or could be; the first is on trial, and alone."""
    log(f"begun:{job.job_id}")
    before, workers = map(int, Path(os.environ["UPWASH_TEST_FIXED"]).read_text().split())

    def begun():
        return Path(os.environ[LOG]).read_text().count("begun:") - before

    deadline = time.monotonic() + 30.0
    while 1 < begun() < 1 + workers and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.02)
    log(f"ended:{job.job_id}")
    return "solved", "", [row(job)]


def on_a_full_disk_when_heavy(job):
    """Meet a full disk beyond 1.25 kg, unless a file says that there is room again."""
    log(job.job_id)
    if job.mass_kg > 1.25 and not is_fixed():
        raise OSError(errno.ENOSPC, "No space left on device", "/scratch/of/the/solver")
    return "solved", "", [row(job)]


def without_its_file(job):
    raise FileNotFoundError(errno.ENOENT, "No such file or directory", f"{job.mass_kg}.csv")
