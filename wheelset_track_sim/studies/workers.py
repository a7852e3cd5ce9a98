"""Independent jobs on all cores of this machine, or on a Dask cluster; one that fails does not end the others."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

from ..errors import InputError, WheelsetTrackError

In = TypeVar("In")
Out = TypeVar("Out")

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
CONNECT = "10s"
"""How long a scheduler may take to answer."""


def on_this_machine(
    work: Callable[[In], Out], jobs: Mapping[int, In], workers: int
) -> Iterator[tuple[int, Out | Exception]]:
    """Number and result, or exception, of each job as it ends, begun in the order given, in processes of their own.

    Processes are spawned, with one thread of linear algebra each. A job whose process dies (memory, a crash) fails;
    jobs that ran beside it are done again, one at a time, so that it is known which of them it was.
    """
    waiting, suspects = deque(jobs), deque[int]()
    while waiting or suspects:
        alone = not waiting
        queue, size = (suspects, 1) if alone else (waiting, workers)
        with _pool(min(size, len(queue))) as pool:
            running: dict[Future[Out], int] = {}
            try:
                while queue or running:
                    while queue and len(running) < size:
                        number = queue.popleft()
                        running[pool.submit(work, jobs[number])] = number
                    for ended in wait(running, return_when=FIRST_COMPLETED).done:
                        failure = ended.exception()
                        if isinstance(failure, BrokenProcessPool):
                            raise failure
                        number = running.pop(ended)
                        yield number, failure if isinstance(failure, Exception) else ended.result()
            except BrokenProcessPool:
                if alone:
                    for number in running.values():
                        yield number, WheelsetTrackError("its process died: out of memory, or a crash")
                else:
                    suspects.extend(running.values())


def on_cluster(
    work: Callable[[In], Out], jobs: Mapping[int, In], address: str
) -> Iterator[tuple[int, Out | Exception]]:
    """The same on the workers of the Dask scheduler at ``address``, such as ``tcp://host:8786``.

    Raises InputError if dask.distributed is not installed or no scheduler answers.
    """
    try:
        cluster: Any = import_module("distributed")
    except ModuleNotFoundError:
        raise InputError("--scheduler needs dask.distributed: pip install 'wheelset_track_sim[dask]'") from None
    try:
        client = cluster.Client(address, timeout=CONNECT)
    except (OSError, ValueError) as reason:
        raise InputError(
            f"--scheduler {address} does not answer ({reason}): start one with dask scheduler, and workers"
        ) from None
    with client:
        if not client.scheduler_info()["workers"]:
            raise InputError(f"--scheduler {address} has no workers: start some with dask worker {address}")
        numbers = {client.submit(work, job, pure=False, retries=1): number for number, job in jobs.items()}
        try:
            for ended in cluster.as_completed(list(numbers)):
                failure = ended.exception()
                yield numbers.pop(ended), failure if isinstance(failure, Exception) else ended.result()
        finally:
            client.cancel(list(numbers))


@contextmanager
def _pool(size: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that end with this one, whatever ends it."""
    others = set(multiprocessing.active_children())
    given = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))  # libraries read it when a process starts
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(size, mp_context=context, initializer=_begin)
    try:
        yield pool
    except BaseException:  # an interrupt above all: do not wait for runs that nobody will read
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in given.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def _begin() -> None:
    """Leave an interrupt to the parent, and end when it ends, even if it was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
