"""The errors that are a user's to correct; each carries the exit code that the command line returns for it.

Anything else that is raised is a bug and keeps its traceback.
"""

from __future__ import annotations

import errno

FAILED_EXIT = 1
"""The exit code of a command that did what it was asked to, where some jobs failed."""


class UpwashError(Exception):
    """A mistake in what was asked or given: bad usage, a bad file, an impossible value.

    The message is one line that says what was expected, what was found, where, and what to do.

    Parameters
    ----------
    message : str
        The line.
    field : str
        The input that is wrong, by its name in a job, a file or a table; "" if it is none in particular.
    cause : str
        A word for what kind of mistake it is, where a program has to tell kinds apart; "" otherwise.

    Examples
    --------
    >>> error = UpwashError("mass_kg: expected a number > 0, found -1; correct it", field="mass_kg")
    >>> str(error), error.field
    ('mass_kg: expected a number > 0, found -1; correct it', 'mass_kg')
    """

    exit_code = 2

    def __init__(self, message: str = "", *, field: str = "", cause: str = "") -> None:
        super().__init__(message)
        self.field = field
        self.cause = cause


class EnvironmentFault(UpwashError):
    """The machine did not do what it must: a full disk, a closed output, a folder that cannot be written.

    It says nothing about a job, so it is never stored as the result of one.
    """


class CheckFailed(UpwashError):
    """A check of results found something that does not hold; the message says what and where."""

    exit_code = 3


REMEDIES = {
    errno.ENOSPC: "make room on that disk",
    errno.EDQUOT: "make room within your quota",
    errno.EFBIG: "raise the limit on the size of files (ulimit -f)",
    errno.EROFS: "take a place that can be written",
    errno.EACCES: "change its permissions, or take another place",
    errno.EPERM: "change its permissions, or take another place",
    errno.EMFILE: "raise the limit on open files (ulimit -n)",
    errno.ENOENT: "check the path",
    errno.ENOMEM: "free some memory, or take fewer workers",
}


def environment_fault(error: OSError | ImportError) -> EnvironmentFault:
    """Return the one line for what the system, or a package that is not whole, said.

    Parameters
    ----------
    error : OSError or ImportError
        What was raised.

    Examples
    --------
    >>> str(environment_fault(OSError(28, "No space left on device", "/data/x.parquet")))
    '/data/x.parquet: expected to use it, found: No space left on device; make room on that disk'
    """
    if isinstance(error, ImportError):
        remedy = "install Upwash again, and 'pip check' what it needs"
        return EnvironmentFault(
            f"{error.name or 'a package'}: expected to import it, found: {error}; {remedy}"
        )
    place = " and ".join(str(name) for name in (error.filename, error.filename2) if name is not None)
    found = error.strerror or str(error) or type(error).__name__
    remedy = REMEDIES.get(error.errno or 0, "correct that, then run the same command again")
    return EnvironmentFault(f"{place or 'this machine'}: expected to use it, found: {found}; {remedy}")
