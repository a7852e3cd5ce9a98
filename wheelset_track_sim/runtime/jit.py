"""Decorators for compiled kernels, with a cache on disk that cannot go stale.

Numba's cache notices an edit of the file that holds a function, not of a file whose functions it calls. So the name of
the cache folder is a digest of every kernel source in the package: an edit of any of them compiles all again. Compiled
functions are in modules named ``*kernels.py``, which the digest covers.
"""

from __future__ import annotations

import hashlib
import logging
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numba.experimental.function_type  # numba itself imports it too late for ``Address``
import platformdirs

from .cores import cores

config: Any = numba.config
typeof: Any = numba.typeof
Function = TypeVar("Function", bound=Callable[..., Any])

DONE = "compiled"
"""File in the folder of kernels; the kernels of a run are compiled if it exists."""

log = logging.getLogger(__name__)


def caches() -> Path:
    """Folder that holds a folder of compiled kernels for each version of their sources."""
    return Path(config.CACHE_DIR or platformdirs.user_cache_path("wheelset_track_sim")) / "kernels"


@cache
def cache_folder() -> Path:
    """Folder of compiled kernels, named by a digest of their sources, of the options here and of numba's version."""
    package = Path(__file__).parent.parent
    digest = hashlib.blake2b(numba.__version__.encode(), digest_size=8)
    for source in [Path(__file__), *sorted(package.rglob("*kernels.py"))]:
        digest.update(source.relative_to(package).as_posix().encode())
        digest.update(source.read_bytes())
    folder = caches() / digest.hexdigest()
    with suppress(OSError):  # it is not there yet, or read only
        os.utime(folder)  # the time of its last use
    return folder


def mark_compiled() -> None:
    """Record that the kernels of a run are compiled."""
    (cache_folder() / DONE).touch()


@contextmanager
def compiled_meanwhile(module: str) -> Iterator[None]:
    """Compile the kernels of a run in a second process while the body runs, unless they are; wait for it at the end.

    ``module`` compiles them when it is executed, and calls ``mark_compiled``. A thread would not do, for compiler and
    body both hold the interpreter lock. With one core, or if the process fails, kernels are compiled when called.
    """
    if cores() < 2 or (cache_folder() / DONE).exists():
        yield
        return
    process = subprocess.Popen(
        [sys.executable, "-m", module], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield
    except BaseException:
        process.terminate()
        raise
    finally:
        if process.wait() != 0:
            log.debug("kernels were not compiled beforehand: status %d", process.returncode)


def kernel(function: Function) -> Function:
    """Compile a function with numba: cached on disk, without the interpreter lock, NaN kept (no ``fastmath``)."""
    return _compiled(function)


def inner_kernel(function: Function) -> Function:
    """``kernel`` for what the stepping loop calls: put in its place, since passing many arrays costs 70 ns a call."""
    return _compiled(function, forceinline=True)


def summing_kernel(function: Function) -> Function:
    """``inner_kernel`` whose sums may be reordered and contracted, to run in vector registers; NaN is kept."""
    return _compiled(function, forceinline=True, fastmath={"reassoc", "contract", "nsz"})


def block_kernel(function: Function) -> Function:
    """``summing_kernel`` for what takes longer than a call does: compiled once for all who call it."""
    return _compiled(function, fastmath={"reassoc", "contract", "nsz"})


class Address:
    """A kernel that other kernels call by its address: they are compiled without it, and it when one of them is called.

    To them, all kernels of one signature are of one type.
    """

    def __init__(self, function: Any, result: Any, arguments: tuple[Any, ...]) -> None:
        """``result`` and ``arguments`` of ``function``: examples, for their types."""
        self._function, self._address = function, cast("int | None", None)
        self._signature = typeof(result)(*map(typeof, arguments))
        self._numba_type_ = numba.types.FunctionType(self._signature)

    def __wrapper_address__(self) -> int:
        """Where the compiled kernel stands."""
        if self._address is None:
            self._function.compile(self._signature.args)
            compiled = self._function.overloads[self._signature.args]
            self._address = int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))
        return self._address

    def signature(self) -> Any:
        """Types of result and arguments."""
        return self._signature


def _compiled(function: Function, **options: Any) -> Function:
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder())
    try:
        return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy", **options)(function))
    finally:
        config.CACHE_DIR = previous
