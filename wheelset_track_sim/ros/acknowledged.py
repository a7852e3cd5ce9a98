"""What was published last reaches those who listen, before its publisher goes."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from rclpy.duration import Duration

PATIENCE = 1.0
"""Bound on the wait for all of them together, s: a subscriber that does not respond delays the others only so long."""


def wait_for_subscribers(publishers: Iterable[Any]) -> None:
    """Return when all subscribers have what these publishers have sent, or when they have had their time."""
    limit = time.monotonic() + PATIENCE
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, limit - time.monotonic())))
