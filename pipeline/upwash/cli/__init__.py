"""The command ``upwash``: its subcommands, its exit codes, and what an error looks like.

A subcommand's module is imported when that subcommand is called and not before, so that ``upwash --help``
answers at once. Hence the table below holds what the list of commands prints.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import click

from upwash import __version__
from upwash.cli.streams import guarded_streams
from upwash.errors import UpwashError, environment_fault

# heading of the list -> command -> (module that defines a click command of that name, its one-line summary)
COMMANDS: dict[str, dict[str, tuple[str, str]]] = {
    "Species and single problems": {
        "species": ("species", "List, show, check or start species files."),
        "optimum": ("solve", "Find the best positions of one bird behind another."),
        "flock": ("solve", "Chain pairs into a flock."),
        "phase": ("phase", "Find the best phase against distance, in a V and in line."),
        "robust": ("robust", "Say what is left of the best saving while a bird drifts."),
        "speed": ("journey", "Find how fast a bird does best alone and in flocks."),
        "migrate": ("journey", "Fly a flock on its fuel, and a bird alone beside it."),
        "field": ("pictures", "Map the force on a follower over a plane."),
        "animate": ("pictures", "Animate a flock flapping in its wakes."),
        "explore": ("explore", "Write a page on which to drag a follower about."),
    },
    "Birds that were seen": {
        "evaluate": ("observed", "Say what observed birds save where they fly."),
        "map": ("saving_map", "Map what a follower saves at each place of a plane."),
    },
    "Sweeps over many": {
        "run": ("runs", "Solve every job of a sweep; finished jobs are kept."),
        "merge": ("runs", "Make one results folder of those of a sweep's parts."),
        "status": ("results", "Say how far a sweep has come."),
        "aggregate": ("runs", "Gather the jobs' results into one table each."),
        "check": ("results", "Check that a results folder holds what it must."),
        "show": ("results", "Show one job: inputs, optima, residuals."),
        "rerun": ("results", "Solve chosen jobs again."),
        "diff": ("results", "Compare two results folders, job by job."),
        "page": ("pictures", "Draw a sweep's figures and write the page that tells its story."),
    },
    "The paper": {
        "reproduce": ("reproduce", "Redo the paper, and print its table beside ours."),
        "claims": ("claims", "Judge each claim of the paper by our numbers."),
        "literature": ("literature", "Set what others published beside both models."),
    },
    "This machine": {
        "warm": ("warm", "Compile now what commands would compile when first called."),
    },
}

INTERRUPTED = 130  # 128 + SIGINT, as shells report it
OUTPUT_CLOSED = 141  # 128 + SIGPIPE; 1 would say that jobs failed


class OneLineError(click.ClickException):
    """A user's mistake, shown as one line on standard error."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(" ".join(message.split()))
        self.exit_code = exit_code  # type: ignore[misc]  # click reads it from the instance


@contextmanager
def users_errors() -> Iterator[None]:
    """Turn mistakes, faults of the machine and interruptions into one line and an exit code.

    Bugs keep their traceback.
    """
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "upwash"
        message = f"{error.format_message().rstrip('.')}. See '{command} --help'."
        raise OneLineError(message, error.exit_code) from error
    except click.FileError as error:
        raise OneLineError(error.format_message(), UpwashError.exit_code) from error
    except UpwashError as error:
        raise OneLineError(str(error), error.exit_code) from error
    except KeyboardInterrupt:
        click.echo("Interrupted.", err=True)
        raise click.exceptions.Exit(INTERRUPTED) from None
    except BrokenPipeError:
        # Whoever read our output has left.
        raise click.exceptions.Exit(OUTPUT_CLOSED) from None
    except OSError as error:
        fault = environment_fault(error)
        raise OneLineError(str(fault), fault.exit_code) from error


class LazyGroup(click.Group):
    """A click group that imports a subcommand's module only when the subcommand is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Name the subcommands in the order of the table."""
        return [name for commands in COMMANDS.values() for name in commands]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import and return a subcommand, or None if there is none of that name."""
        for commands in COMMANDS.values():
            if name in commands:
                return getattr(import_module(f"upwash.cli.{commands[name][0]}"), name)
        return None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of subcommands from the table alone."""
        for heading, commands in COMMANDS.items():
            with formatter.section(heading):
                formatter.write_dl([(name, summary) for name, (_, summary) in commands.items()])

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the command, and guard what it writes to."""
        with guarded_streams():
            return super().main(*args, **extra)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Parse the group's own options."""
        with users_errors():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Parse and run the subcommand."""
        with users_errors():
            return super().invoke(ctx)


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, message="%(prog)s %(version)s")
def main() -> None:
    """Optimal formation flight of flapping birds, from a minimal wake-vortex model.

    \b
    Example:
      upwash optimum northern-bald-ibis --objective force

    Results go to standard output, everything else to standard error. Exit codes: 0 done, 1 some jobs failed,
    2 bad usage, input or environment, 3 a check failed.
    """
