"""Linear algebra on one core, so that results do not depend on how many a machine has.

A BLAS that deals a product out to several threads adds it up in another order, and a balanced reduction makes newtons
of that: 2 N of 291 kN in an impact. For matrices of this size one thread is the faster, too.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import ParamSpec, TypeVar

import scipy.linalg  # noqa: F401  the limit is set on the libraries that are loaded, SciPy's among them
from threadpoolctl import ThreadpoolController

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class _Limit:
    """The limit of this process, shared by the threads that are in need of it: the last one out lifts it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0

    @contextmanager
    def __call__(self) -> Iterator[None]:
        with self._lock:
            if self._inside == 0:
                _take_control()
                self._limited = _libraries().limit(limits=1, user_api="blas")
            self._inside += 1
        try:
            yield
        finally:
            with self._lock:
                self._inside -= 1
                if self._inside == 0:
                    _take_control()
                    self._limited.restore_original_limits()


one_core = _Limit()
"""Context in which BLAS runs on the calling thread alone; from several threads at a time, too."""


def on_one_core(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """``function``, always run in ``one_core``."""

    @wraps(function)
    def limited(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        with one_core():
            return function(*args, **kwargs)

    return limited


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


def _take_control() -> None:
    """From now on it is this thread that sets limits: threadpoolctl 3.8 lets but one do so, silently."""
    for library in _libraries().lib_controllers:
        release = getattr(library, "clear_controlling_thread", None)
        if release is not None:
            release(force=True)
