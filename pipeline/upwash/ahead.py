"""Compiling ahead: all kernels that the commands need, in two processes at once.

A kernel is compiled for the types of what it is first given.  So each part here does once, and as little of it as there
is, what commands do: what that compiles is what they will load, and no list of kernels has to be kept.
"""

from __future__ import annotations

import json
import logging
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from queue import SimpleQueue
from threading import Thread
from typing import Any

from upwash.errors import EnvironmentFault, UpwashError, environment_fault

PROCESSES = 2
SPECIES = "northern-bald-ibis"
"""Whose follower is solved for; the kernels are the same for all."""

PAPER, LIMIT = "paper", "limit"


def _asked(model: str) -> tuple[Any, Any]:
    from upwash.aero.wake import WakeModel
    from upwash.species import load_species

    return load_species(SPECIES).bird(), WakeModel.named(model)


def _search(model: str) -> None:
    from upwash.optimum.endless.search import EndlessSearch
    from upwash.optimum.pair import pair_problems
    from upwash.optimum.search import Search

    bird, wake = _asked(model)
    problem: Any = pair_problems(bird, "force", model=wake)[0]
    (EndlessSearch(problem) if wake.is_endless else Search(problem)).explore_places(1)


def _prove(model: str) -> None:
    from upwash.optimum.certify import certify
    from upwash.optimum.endless.solve import certify_endless
    from upwash.optimum.pair import pair_problems

    bird, wake = _asked(model)
    problem: Any = pair_problems(bird, "force", model=wake)[0]
    (certify_endless if wake.is_endless else certify)(problem, problem.bounds, 1.0, 1e-3, 1)


def _tell(model: str) -> None:
    """Solve a pair without a proof: beside the search that is what is told of optima, on core edges and off them."""
    from upwash.optimum.pair import solve_pair
    from upwash.optimum.settings import SearchSettings

    bird, wake = _asked(model)
    solve_pair(bird, "force", model=wake, search=SearchSettings(most_boxes=1))


def _map_forces(model: str) -> None:
    from upwash.aero.field_map import force_map
    from upwash.aero.pose import Pose, Stroke

    bird, wake = _asked(model)
    stroke = Stroke(bird.amplitude_m, bird.upstroke_span_ratio)
    force_map(bird, stroke, Pose(1.8, 0.9, 0.0, stroke, 0.5), "xy", [1.8, 1.9], [0.9, 1.0], wake)


def _evaluate(model: str) -> None:
    import pandas as pd

    from upwash.place.balance import Behind
    from upwash.study.observed.evaluation import evaluate

    bird, wake = _asked(model)
    Behind(bird, "power", model=wake).balances([(1.8, 0.9, 0.1, 0.5)])
    seen = pd.DataFrame({"x_m": [1.8, 1.8], "y_m": [0.9, 0.9], "z_m": [0.1, None], "phase": [0.5, None]})
    evaluate(bird, seen, model=wake, sigma=0.05, finds_optimum=False)


def _drift(model: str) -> None:
    from upwash.aero.pose import Pose, Stroke
    from upwash.place.balance import Behind
    from upwash.place.robust import Jittering, Spread

    bird, wake = _asked(model)
    jittering = Jittering(Behind(bird, "power", model=wake), Spread.of_place(0.05))
    jittering.remaining(Pose(1.8, 0.9, 0.0, Stroke(bird.amplitude_m, bird.upstroke_span_ratio), 0.5))


def _map_savings(model: str) -> None:
    from upwash.study.saving_map import map_savings

    bird, wake = _asked(model)
    map_savings(bird, "yz", size=2, held={"x": 1.8}, model=wake, finds_optimum=False)


_WAKES = {PAPER: "behind a wake that ends", LIMIT: "in the limit"}
_WORK: dict[str, Callable[[str], None]] = {
    # What takes longest is first, so that both processes end together.
    "the search": _search,
    "the proof": _prove,
    "what is told of optima": _tell,
    "observed birds": _evaluate,
    "birds that drift": _drift,
    "maps of saving": _map_savings,
    "maps of force": _map_forces,
}
PARTS: dict[str, Callable[[], None]] = {
    f"{what} {where}": partial(work, model) for what, work in _WORK.items() for model, where in _WAKES.items()
}
"""What is compiled, by what it is called, in the order in which it is begun."""


@dataclass(frozen=True)
class Compiled:
    """What has become of a part.

    Attributes
    ----------
    part : str
        A key of `PARTS`.
    kernels : int
        How many kernels were compiled for it that were not before.
    """

    part: str
    kernels: int


def compile_ahead(begun: Callable[[str], None] = lambda part: None) -> Iterator[Compiled]:
    """Compile whatever commands need and is not compiled yet, and keep it.

    Parameters
    ----------
    begun : callable
        Called with the name of each part when it is begun, from other threads.

    Yields
    ------
    Compiled
        Each part when it is done.

    Raises
    ------
    EnvironmentFault
        If no folder can be written that would keep what is compiled, or this machine does not let it be compiled.

    Examples
    --------
    >>> kernels = sum(done.kernels for done in compile_ahead())
    """
    waiting: SimpleQueue[str | None] = SimpleQueue()
    answers: SimpleQueue[dict[str, Any]] = SimpleQueue()
    for name in [*PARTS, *[None] * PROCESSES]:
        waiting.put(name)
    processes = [_start() for _ in range(PROCESSES)]
    feeding = [Thread(target=_feed, args=(one, waiting, answers, begun), daemon=True) for one in processes]
    for thread in feeding:
        thread.start()
    try:
        for _ in PARTS:
            answer = answers.get()
            if "bug" in answer:
                raise RuntimeError(answer["bug"])
            if "fault" in answer:
                raise EnvironmentFault(answer["fault"])
            yield Compiled(**answer)
    finally:
        for process, thread in zip(processes, feeding, strict=True):
            process.kill()
            thread.join()
            with suppress(BrokenPipeError), process:
                pass  # whose pipes are closed


def kept_in() -> str:
    """Return the folder that holds compiled code, or "" if none does yet."""
    from upwash.kernel import cache_folders

    return next((str(path) for path in cache_folders() if path.exists()), "")


def _start() -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "upwash.ahead"]
    pipes: dict[str, Any] = {
        "stdin": subprocess.PIPE,
        "stdout": subprocess.PIPE,
        "stderr": subprocess.DEVNULL,
    }
    return subprocess.Popen(command, encoding="utf-8", **pipes)


def _feed(
    process: subprocess.Popen[str],
    waiting: SimpleQueue[str | None],
    answers: SimpleQueue[dict[str, Any]],
    begun: Callable[[str], None],
) -> None:
    """Give a process one part after the other, and pass on what it answers."""
    assert process.stdin and process.stdout
    while (name := waiting.get()) is not None:
        begun(name)
        try:
            print(name, file=process.stdin, flush=True)
            answer = process.stdout.readline()
        except OSError:
            answer = ""
        if not answer:
            ended = f"{name}: expected it to be compiled, found the process ended with {process.wait()}"
            answers.put({"fault": f"{ended}; free some memory, then run the same command again"})
            return
        answers.put(json.loads(answer))


class _Heard(logging.Handler):
    """Counts what was compiled, and keeps the last warning: that it could not be kept."""

    def __init__(self) -> None:
        super().__init__()
        self.kernels = 0
        self.fault = ""

    def emit(self, record: logging.LogRecord) -> None:
        """Take what a kernel has to say."""
        if record.levelno == logging.DEBUG:
            self.kernels += 1
        elif record.levelno >= logging.WARNING:
            self.fault = record.getMessage()


def _answer(name: str) -> dict[str, Any]:
    """Compile a part; return what is to be said of it."""
    heard, logger = _Heard(), logging.getLogger("upwash.kernel")
    logger.setLevel(logging.DEBUG)
    logger.addHandler(heard)
    try:
        PARTS[name]()
    except UpwashError as error:
        return {"fault": str(error)}
    except (OSError, ImportError) as error:
        return {"fault": str(environment_fault(error))}
    except Exception:
        return {"bug": traceback.format_exc()}
    finally:
        logger.removeHandler(heard)
    return {"fault": heard.fault} if heard.fault else {"part": name, "kernels": heard.kernels}


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(_answer(line.rstrip("\n"))), flush=True)
