"""Contact laws of coming surfaces, worked out while the run goes on, so that a change does not make it wait."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

from ..contact.law_kernels import ContactLaw
from ..irregularities import Irregularity
from ..runtime.progress import Progress
from .models import Models, with_own_state

KEPT = 2
"""Laws that are kept: that of a change at hand and that of the next event."""
_POOL = ThreadPoolExecutor(max_workers=1, thread_name_prefix="laws-ahead")


class LawsAhead:
    """The contact laws of one run; methods may be called from any thread. What is worked out ahead changes no bit."""

    def __init__(self, models: Models) -> None:
        """Of ``models``; nothing is worked out yet."""
        self._models = models
        self._lock = threading.Lock()
        self._known: dict[tuple[object, ...], Future[ContactLaw]] = {}

    def begin(self, irregularities: Sequence[Irregularity], line_length: float | None) -> None:
        """Have a law worked out in the background."""
        with self._lock:
            key = (tuple(irregularities), line_length)
            if key not in self._known:
                self._keep(key, _POOL.submit(self._models.contact_law, irregularities, None, line_length))

    def law(
        self, irregularities: Sequence[Irregularity], line_length: float | None, progress: Progress | None
    ) -> ContactLaw:
        """The law with a state of its own; worked out here, with ``progress``, if it is not under way."""
        key = (tuple(irregularities), line_length)
        with self._lock:
            under_way = self._known.get(key)
        if under_way is not None:
            return with_own_state(under_way.result())
        law = self._models.contact_law(irregularities, progress, line_length)
        done: Future[ContactLaw] = Future()
        done.set_result(law)
        with self._lock:
            self._keep(key, done)
        return with_own_state(law)

    def _keep(self, key: tuple[object, ...], law: Future[ContactLaw]) -> None:
        self._known[key] = law
        for old in [*self._known][:-KEPT]:
            del self._known[old]
