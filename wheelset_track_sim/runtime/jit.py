"""Decorators for compiled kernels, with a cache on disk that cannot go stale.

Numba's cache notices an edit of the file that holds a function, not of a file whose functions it calls. So the name of
the cache folder is a digest of every kernel source in the package: an edit of any of them compiles all again. Compiled
functions are in modules named ``*kernels.py``, which the digest covers.
"""

from __future__ import annotations

import atexit
import fcntl
import hashlib
import logging
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numba.experimental.function_type  # numba itself imports it too late for ``Address``
import platformdirs
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from .cores import cores

config: Any = numba.config
typeof: Any = numba.typeof
Function = TypeVar("Function", bound=Callable[..., Any])

APART = "WHEELSET_TRACK_SIM_COMPILES_APART"
"""Set in the processes that compile kernels for others."""
DONE = "compiled"
"""File in the folder of kernels, with the name of a set of kernels behind it, which are compiled if it exists."""

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


@cache
def trusted_folder() -> Path | None:
    """``cache_folder``, made for its owner alone; None, with a warning, if others can write to it or own it.

    Compiled kernels are machine code, and numba reads them with pickle: they are used as if they were part of the
    package. A folder that cannot be made is left to numba, which names the reason.
    """
    folder = cache_folder()
    with suppress(OSError):
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if hasattr(os, "geteuid"):
            status = folder.stat()
            if status.st_uid not in (os.geteuid(), 0) or status.st_mode & 0o022:
                log.warning(
                    "compiled kernels in %s are not used, because other users can write there: remove that folder",
                    folder,
                )
                return None
    return folder


def compiled(kernels: str) -> Path:
    """File that exists if a set of kernels is compiled."""
    return cache_folder() / f"{DONE}-{kernels}"


@contextmanager
def compiled_meanwhile(module: str, kernels: str) -> Iterator[None]:
    """Compile a set of kernels in a second process while the body runs, unless they are; wait for it at the end.

    ``module`` compiles them when it is executed with their name, and marks them as ``compiled``. A thread would not do,
    for compiler and body both hold the interpreter lock. With one core, or if the process fails, kernels are compiled
    when called.
    """
    folder = trusted_folder()
    if cores() < 2 or folder is None or compiled(kernels).exists():
        yield
        return
    process = _compiling(module, kernels, apart=True)
    try:
        yield
    except BaseException:
        process.terminate()
        raise
    finally:
        if process.wait() != 0:
            log.debug("kernels could not be compiled in advance: status %d", process.returncode)


def compile_ahead(module: str, kernels: str) -> None:
    """Begin to compile a set of kernels in a second process, unless they are; do not wait for it.

    It ends with this process at the latest. A kernel that is called before it is ready is waited for.
    """
    if APART in os.environ or trusted_folder() is None or compiled(kernels).exists():
        return
    with _AHEAD_LOCK:
        if kernels not in _AHEAD:
            _AHEAD[kernels] = _compiling(module, kernels, apart=False)
            atexit.register(_AHEAD[kernels].terminate)


_AHEAD: dict[str, subprocess.Popen[bytes]] = {}
_AHEAD_LOCK = threading.Lock()


def _compiling(module: str, kernels: str, *, apart: bool) -> subprocess.Popen[bytes]:
    """Process that compiles kernels; ``apart``, it does so itself, else in processes that take turns with others."""
    return subprocess.Popen(
        [sys.executable, "-m", module, kernels],
        env=os.environ | ({APART: "1"} if apart else {}),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


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


def bare_kernel(function: Function) -> Function:
    """``summing_kernel`` that allocates nothing: references to arrays are not counted, which takes 3 ns each time."""
    return _compiled(function, forceinline=True, fastmath={"reassoc", "contract", "nsz"}, _nrt=False)


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
        """Path of the compiled kernel."""
        if self._address is None:
            self._function.compile(self._signature.args)
            compiled = self._function.overloads[self._signature.args]
            self._address = int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))
        return self._address

    def signature(self) -> Any:
        """Types of result and arguments."""
        return self._signature


class _KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """numba's cache of one kernel: what cannot be read, as after a power loss, or written, is reported and left.

    A kernel is not compiled where it is missing but in a process of its own, and then loaded: it depends on what has
    been compiled before which functions the compiler puts in place, and so does the last bit of a sum. This way the
    first run has the same machine code as all later ones.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled kernel for a signature; None if there is none, and none can be made apart."""
        found = self._load(sig, target_context)
        if found is None and _compiled_apart(self._py_func, sig):
            found = self._load(sig, target_context)
        return found

    def _load(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception as damage:  # noqa: BLE001  any damage whatever ends in a compilation
            log.warning("compiled kernel in %s cannot be read (%r): compiled again", self.cache_path, damage)
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store a compiled kernel."""
        try:
            super().save_overload(sig, data)
        except OSError as reason:
            log.warning("compiled kernel is not stored: %s cannot be written (%s)", self.cache_path, reason.strerror)


def _compiled_apart(function: Callable[..., Any], signature: Any) -> bool:
    """Whether another process has compiled and stored a kernel of this package."""
    if APART in os.environ or function.__module__.partition(".")[0] != __name__.partition(".")[0]:
        return False
    done = subprocess.run(
        [sys.executable, "-m", __name__],
        input=dumps((function.__module__, function.__name__, signature)),
        env=os.environ | {APART: "1"},
        capture_output=True,
        check=False,
    )
    if done.returncode != 0:
        log.debug(
            "%s could not be compiled in a process of its own: %s",
            function.__name__,
            done.stderr.decode(errors="replace"),
        )
    return done.returncode == 0


def _compile_asked_for() -> None:
    """Compile the kernel that standard input names; one process at a time, so that none is stored twice."""
    module, name, signature = pickle.load(sys.stdin.buffer)
    with (cache_folder() / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        getattr(import_module(module), name).compile(signature)


def _compiled(function: Function, **options: Any) -> Function:
    compiled = numba.njit(nogil=True, error_model="numpy", **options)(function)
    folder = trusted_folder()
    if folder is not None:
        previous = config.CACHE_DIR
        config.CACHE_DIR = str(folder)
        try:
            compiled._cache = _KernelCache(function)
        finally:
            config.CACHE_DIR = previous
    return cast(Function, compiled)


if __name__ == "__main__":
    _compile_asked_for()
