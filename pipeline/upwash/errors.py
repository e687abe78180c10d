"""The errors that are a user's to mend; each carries the exit code that the command line returns for it.

Anything else that is raised is a bug and keeps its traceback.
"""


class UpwashError(Exception):
    """A mistake in what was asked or given: bad usage, a bad file, an impossible value.

    The message is one line that says what was expected, what was found, where, and what to do.
    """

    exit_code = 2


class CheckFailed(UpwashError):
    """A check of results found something that does not hold; the message says what and where."""

    exit_code = 3
