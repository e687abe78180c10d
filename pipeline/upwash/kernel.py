"""Compiling the loops of the physics, and keeping what was compiled for as long as it is what the sources say.

numba's own cache renews a compiled function when that function's file changes: too often, since a comment is a
change as well, and too seldom, since a function or a constant that it takes from another file is not looked at.
A stale kernel would silently compute yesterday's physics. Here a file of compiled code is named after all that
went into it: the kernel's instructions, those of each kernel that it calls, the values of each constant that it
reads, how it is compiled, for which processor, and by which compiler. So what is found is right, in whatever
folder, and however many processes put files there at once. numba's settings stay the user's own.
"""

from __future__ import annotations

import dis
import inspect
import logging
import os
import pickle
import platform
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from numba.core import config, types
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs

PACKAGE = Path(__file__).parent
SUFFIX = ".kernel"
DIGEST_SIZE = sha256().digest_size
OF_ONE_USER = "upwash-kernels-"

COMPILING = (
    "compiling what this needs, once for this version of the kernels: 5 to 20 s ('upwash warm' compiles all)"
)
"""What a person is told before the first kernel is compiled; it takes far longer than a solve."""

LOGGER = logging.getLogger(__name__)

# What makes parts of kernels reaches into numba, and was tried with one version of it: others compile as they always
# do, to the same results in twice the time.
if version("numba").startswith("0.68."):
    from upwash.parts import PART, WHOLE
else:
    PART = WHOLE = {}

SIGNATURE_FLAGS = inspect.CO_VARARGS | inspect.CO_VARKEYWORDS | inspect.CO_GENERATOR


def kernel(function: Callable[..., Any] | None = None, /, *, allocates: bool = True, **flags: Any) -> Any:
    """Compile a function when it is first called, and keep the code between runs.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and named tuples that numba can compile. It may use other kernels, and
        constants of any module that are numbers, text, arrays, or tuples of those.
    allocates : bool
        Whether it makes arrays.  A kernel that makes none, and calls none that does, need not count who holds those
        that it is given, which takes time where they are many and the work is little.
    **flags
        Options of `numba.njit`; ``nogil=True`` and ``error_model="numpy"`` unless said otherwise.

    Returns
    -------
    callable
        The kernel; or, without a function, the decorator that makes it.

    Examples
    --------
    >>> @kernel
    ... def hypotenuse(a, b):
    ...     return (a * a + b * b) ** 0.5
    >>> hypotenuse(3.0, 4.0)
    5.0
    """
    if function is None:
        return lambda function: kernel(function, allocates=allocates, **flags)
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": allocates} | flags
    compiled: Any = numba.njit(**options | WHOLE)(function)
    if hasattr(compiled, "py_func"):  # and not the function itself, under NUMBA_DISABLE_JIT
        compiled._cache = _Kept(compiled)
        if PART:
            part = numba.njit(**options | PART)(function)
            compiled.get_call_template, compiled.get_overload = part.get_call_template, part.get_overload
    return compiled


def is_kept(compiled: Any) -> bool:
    """Whether some compiled code of a kernel, as it is written now, is kept for this machine."""
    if not isinstance(compiled, Dispatcher):
        return True
    return any(any(folder.glob(f"{_name(compiled)}-*{SUFFIX}")) for folder in cache_folders())


def cache_folders() -> tuple[Path, ...]:
    """Return the folders that may hold compiled code, the preferred one first.

    Where the user says (``NUMBA_CACHE_DIR``), or else beside the package; in the user's cache folder; among
    temporary files. Each is looked into, and the first that can be written is written to.
    """
    chosen: str = vars(config)["CACHE_DIR"]
    first = Path(chosen).absolute() / "upwash" if chosen else PACKAGE / "__pycache__" / "kernels"
    users = Path(AppDirs(appname="upwash", appauthor=False).user_cache_dir) / "kernels"
    return tuple(path for path in (first, users, *_temporary_folder()) if path.is_absolute())


def _temporary_folder() -> Iterator[Path]:
    with suppress(OSError):
        parent = Path(tempfile.gettempdir())
        if hasattr(os, "getuid") and parent != Path.cwd():
            yield parent / f"{OF_ONE_USER}{os.getuid()}"


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can have put code there; asked of the folder whose parent anybody may write to."""
    if not folder.name.startswith(OF_ONE_USER):
        return True
    about = folder.lstat()
    return stat.S_ISDIR(about.st_mode) and about.st_uid == os.getuid() and not about.st_mode & 0o022


class _Kept:
    """The compiled code of one kernel on the disk, a file a signature: what numba asks for and gives away."""

    def __init__(self, dispatcher: Any) -> None:
        self._dispatcher = dispatcher

    @property
    def cache_path(self) -> str:
        """The folder that is looked into first."""
        return str(cache_folders()[0])

    def enable(self) -> None:
        """Do nothing: the cache is always in use."""

    def disable(self) -> None:
        """Do nothing: the cache is always in use."""

    def flush(self) -> None:
        """Do nothing: what is kept is never stale."""

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the code that is kept for some argument types, or None."""
        # Kept code needs numba's memory, and not the registries that compiling needs, which take longer to load.
        rtsys.initialize(context)
        for folder in cache_folders():
            with suppress(OSError):
                data = (folder / self._file(signature)).read_bytes() if _is_ours(folder) else b""
                digest, payload = data[:DIGEST_SIZE], data[DIGEST_SIZE:]
                # A disk that filled up, or a power cut, may have left less than was written.
                if digest == sha256(payload).digest():
                    return CompileResult._rebuild(context, *pickle.loads(payload))
        _tell_once(logging.INFO, COMPILING)
        return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the code for some argument types; where no folder can be written it serves this process alone."""
        if result.lifted or result.library.has_dynamic_globals:
            raise TypeError(f"{self._dispatcher}: expected code that can be kept, found addresses in it")
        LOGGER.debug("compiled %s", self._dispatcher.py_func.__qualname__)
        reduced = result._reduce()
        for environment in reduced[-1]:  # those of parts, which had no place before
            result.library.codegen.set_env(environment.env_name, environment)
        payload = dumps(reduced)
        for folder in cache_folders():
            with suppress(OSError):
                folder.mkdir(
                    mode=0o700 if folder.name.startswith(OF_ONE_USER) else 0o777, parents=True, exist_ok=True
                )
                if _is_ours(folder):
                    _write_atomic(folder / self._file(signature), sha256(payload).digest() + payload)
                    return
        places = ", ".join(map(str, cache_folders()))
        remedy = "set NUMBA_CACHE_DIR to a folder that can be, or each process will compile anew"
        line = f"compiled code: expected a folder that can be written, found none of {places}; {remedy}"
        _tell_once(logging.WARNING, line)

    def _file(self, signature: Any) -> str:
        return f"{_name(self._dispatcher)}-{_digest(_told_type(signature))}{SUFFIX}"


@cache
def _tell_once(level: int, line: str) -> None:
    LOGGER.log(level, line)


def _write_atomic(path: Path, data: bytes) -> None:
    """Write a file that is there whole or not at all."""
    handle, partial = tempfile.mkstemp(prefix=f"{path.name}.", suffix=".tmp", dir=path.parent)
    try:
        with open(handle, "wb") as file:
            file.write(data)
        os.replace(partial, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(partial)
        raise


def _name(dispatcher: Any) -> str:
    """Return how the files of a kernel's code begin: its name, then a digest of all that makes the code."""
    function = dispatcher.py_func
    module = function.__module__.removeprefix("upwash.")
    machine = dispatcher.targetctx.codegen().magic_tuple()
    name = f"{module}.{function.__qualname__}".replace("<", "").replace(">", "")
    return f"{name}-{_digest((_told_kernel(dispatcher), machine, _compiler()))}"


@cache
def _compiler() -> tuple[str, ...]:
    """Return the versions of all that has a part in compiling."""
    packages = (f"{name} {version(name)}" for name in ("numba", "llvmlite", "numpy"))
    return sys.implementation.cache_tag or "", platform.machine(), *packages


def _digest(told: Any) -> str:
    return sha256(repr(told).encode()).hexdigest()[:16]


# What goes into a kernel, told in values whose `repr` is the same in every process.


@cache
def _told_kernel(dispatcher: Any) -> str:
    """Return a digest of a kernel: how it is compiled, and what its function is."""
    function = dispatcher.py_func
    flags = _told(dict(dispatcher.targetoptions), function)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    given = _told([function.__defaults__, function.__kwdefaults__, cells], function)
    # Compiled code looks for the modules of the kernels that it calls.
    return _digest((function.__module__, flags, given, _told_code(function.__code__, function)))


def _told_code(code: CodeType, function: FunctionType) -> Any:
    """Return the instructions of a code object; what documents them, and where they stand, is left out."""
    told: list[Any] = [
        code.co_name,
        code.co_argcount,
        code.co_kwonlyargcount,
        code.co_flags & SIGNATURE_FLAGS,
    ]
    for step in dis.get_instructions(code):
        name, value = "", step.argval
        if step.opname == "LOAD_GLOBAL":
            # None stands for Python's own names.
            name, value = step.argval, function.__globals__.get(step.argval)
            if getattr(value, "py_func", None) is function:
                value = "itself"
        told.append((step.opname, name, _told(value, function)))
    return told


def _told(value: Any, function: FunctionType) -> Any:
    """Return the content of a constant or the name of what is not the package's own."""
    if isinstance(value, Dispatcher):
        return _told_kernel(value)
    if isinstance(value, CodeType):
        return _told_code(value, function)
    if isinstance(value, tuple | list):
        return type(value).__name__, [_told(each, function) for each in value]
    if isinstance(value, frozenset | set):
        return "set", sorted(repr(_told(each, function)) for each in value)
    if isinstance(value, dict):
        return "dict", sorted(repr((key, _told(each, function))) for key, each in value.items())
    if isinstance(value, np.ndarray | np.generic):
        return str(value.dtype), value.shape, value.tobytes()
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        return type(value).__name__, repr(value)
    if isinstance(value, type) and issubclass(value, tuple):
        return _told_named_tuple(value)
    if isinstance(value, ModuleType):
        name = value.__name__
    else:
        name = f"{getattr(value, '__module__', None)}.{getattr(value, '__qualname__', None)}"
    # What another package does is told by its version.
    if name.split(".")[0] in ("builtins", "math", "numba", "numpy"):
        return name
    raise TypeError(
        f"{function.__module__}.{function.__qualname__}: expected a kernel to use kernels, and constants that are "
        f"numbers, text, arrays, or tuples of those, by their own names; found {value!r}"
    )


def _told_named_tuple(kind: type) -> Any:
    return kind.__qualname__, getattr(kind, "_fields", ())


def _told_type(kind: Any) -> Any:
    """Return what an argument's type is, with the names of its fields, which its own text may leave out."""
    if isinstance(kind, tuple | list):
        return [_told_type(each) for each in kind]
    if isinstance(kind, types.BaseTuple):
        parts: Any = kind
        named = _told_named_tuple(kind.instance_class) if hasattr(kind, "instance_class") else ()
        return str(kind), named, [_told_type(each) for each in parts]
    return str(kind)
