"""Several wheelsets in one process: models and compiled kernels in common, everything that changes of each its own."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from types import TracebackType
from typing import TYPE_CHECKING
from weakref import WeakValueDictionary

from ..runtime.cache import digest
from ..runtime.cores import cores
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..scenario import Scenario
from .models import Models, load_models
from .simulator import CHANGEABLE, Simulator

if TYPE_CHECKING:
    from typing_extensions import Self


WAITING = "wait for the models that another wheelset builds"
"""Stage of progress."""


class ModelPool:
    """Models in use: each is built once for all that run on it, and freed with the last of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._building: dict[str, threading.Lock] = {}
        self._models: WeakValueDictionary[str, Models] = WeakValueDictionary()

    def models(self, scenario: Scenario, progress: Progress | None = None) -> Models:
        """Models of a scenario; waits for another thread that builds the same. Raises InputError as ``load_models``."""
        kept = {field.name: getattr(scenario, field.name) for field in fields(Scenario) if field.name not in CHANGEABLE}
        key = digest(kept)
        with self._lock:
            building = self._building.setdefault(key, threading.Lock())
        if progress is not None and building.locked():
            progress(WAITING, 0.0)
        with building:
            models = self._models.get(key)
            if models is None:
                models = load_models(scenario, progress)
                models.contact_law((), progress)  # of the smooth tread, which all of them settle on
                self._models[key] = models
        return models


class Fleet:
    """Simulators that go on side by side, as many at a time as there are threads; a context manager.

    The kernels of the stepping loop run without the interpreter lock. Each simulator gives the same bits as alone.

    Parameters
    ----------
    scenarios
        One for each wheelset.
    progress
        Called with stage and fraction while models are built.
    threads
        Number of threads; the number of cores if None.

    Examples
    --------
    >>> with Fleet([load_scenario("damage_wheel_1"), load_scenario("undamaged")]) as fleet:
    ...     first, second = fleet.advance(1000)  # the blocks of each wheelset
    >>> sum(len(block) for block in first)
    1000
    """

    def __init__(
        self, scenarios: Sequence[Scenario], progress: Progress | None = None, *, threads: int | None = None
    ) -> None:
        """Load or build the models and settle; ``threads`` is the number of cores if None. Raises InputError."""
        pool = ModelPool()

        def simulator(scenario: Scenario) -> Simulator:
            built = Simulator(scenario, progress, pool.models(scenario, progress))
            built.settle()
            return built

        self._executor = ThreadPoolExecutor(threads or cores(), "wheelset")
        try:
            self.simulators = tuple(self._executor.map(simulator, scenarios))
        except BaseException:
            self._executor.shutdown(cancel_futures=True)
            raise

    def advance(self, steps: int) -> list[list[SampleBlock]]:
        """The next ``steps`` samples of each wheelset, in several blocks where changes take effect among them.

        Raises what ``Simulator.advance`` raises, for the first wheelset that fails.
        """
        return list(self._executor.map(lambda simulator: _advance(simulator, steps), self.simulators))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._executor.shutdown(cancel_futures=True)


def _advance(simulator: Simulator, steps: int) -> list[SampleBlock]:
    blocks = []
    while steps > 0:
        blocks.append(simulator.advance(steps))
        steps -= len(blocks[-1])
    return blocks
