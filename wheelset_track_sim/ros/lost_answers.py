"""Answers of services that the middleware could not deliver: counted, logged, told in diagnostics.

Before it sends an answer, ``rmw_fastrtps`` waits up to 0.1 s until it has matched the client that is to receive it
(``rmw_response.cpp``). If it has not by then, as on a machine that is too busy, nothing is sent, and ``rclpy`` warns
with a RuntimeWarning. What a server cannot see: a client that has gone meanwhile, and an answer for which the client's
own queue has no room.
"""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy

from ..monitoring.status import Status
from ..verdict.limit_set import Level

UNDELIVERED = "failed to send response"
"""Beginning of the warning of rclpy."""
RECENT = 60.0
"""Time for which a lost answer counts as a warning, s."""

_sending = threading.local()


class LostAnswers:
    """Watches the services of one node."""

    def __init__(self, log: Any, clock: Callable[[], float] = time.monotonic) -> None:
        """Lost answers are logged to ``log``; ``clock`` returns the time, s."""
        _catch_warnings()
        self._log, self._clock = log, clock
        self._lock = threading.Lock()
        self._count, self._latest, self._when = 0, "", 0.0

    def watch(self, service: Any) -> None:
        """Count the answers of a service of rclpy that are lost from here on."""
        send, name = service.send_response, service.srv_name

        def watched(response: Any, header: Any) -> None:
            _sending.lose = lambda reason: self._lose(name, reason)
            try:
                send(response, header)
            except InvalidHandle:  # the node is being destroyed
                raise
            except _rclpy.RCLError as reason:
                self._lose(name, str(reason))
            finally:
                _sending.lose = None

        service.send_response = watched

    def status(self) -> Status:
        """For diagnostics."""
        with self._lock:
            count, latest, age = self._count, self._latest, self._clock() - self._when
        told = f"{count} answers lost, the latest of {latest}" if count else "all answers are sent"
        level = Level.WARN if count and age < RECENT else Level.OK
        return Status("services", level, told, (("lost_answers", str(count)),))

    def _lose(self, name: str, reason: str) -> None:
        with self._lock:
            self._count, self._latest, self._when = self._count + 1, name, self._clock()
        self._log.warning(f"{name}: an answer is lost, its client was not found in time ({' '.join(reason.split())})")


@cache
def _catch_warnings() -> None:
    """Hand the warning of rclpy over to the service that is sending, once for this process."""
    show = warnings.showwarning

    def shown(message: Warning | str, *where: Any, **options: Any) -> None:
        lose = getattr(_sending, "lose", None)
        if lose is not None and str(message).startswith(UNDELIVERED):
            lose(str(message))
        else:
            show(message, *where, **options)

    warnings.showwarning = shown
    warnings.filterwarnings("always", f"{UNDELIVERED}.*", RuntimeWarning)
