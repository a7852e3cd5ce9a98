"""When a replay begins: after its delay, and when subscribers that are there already have been found."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..inputs.schema import check, quantity

SETTLED = 0.5
"""Time without a further subscription after which all that are there count as found, s."""


@dataclass(frozen=True)
class Start:
    """How long a replay stands before its first message; in real time."""

    delay: float = quantity("s", 0.0, 1e6, "the time that passes before the replay begins", default=0.0)
    wait: float = quantity("s", 0.0, 1e6, "the longest time to wait for a subscription, 0 for not at all", default=2.0)

    def __post_init__(self) -> None:
        check(self)

    def ready(self, publishers: Sequence[Any], clock: Callable[[], float] = time.monotonic) -> Callable[[], bool]:
        """Whether to begin, to be asked again and again; time counts from this call on, by ``clock``, s.

        The middleware takes a while until it has matched subscribers that are there already, and what is published by
        then is lost to them.
        """
        begun = since = clock()
        matched = 0

        def ready() -> bool:
            nonlocal matched, since
            now, found = clock(), sum(publisher.get_subscription_count() for publisher in publishers)
            if found != matched:
                matched, since = found, now
            settled = matched > 0 and now - since >= SETTLED
            return now - begun >= self.delay and (settled or now - begun >= self.wait)

        return ready
