"""Interrupts while modules load.

Libraries that are being imported may swallow KeyboardInterrupt. Others let it pass through ``exec`` of a text, and then
Python ends by the signal whatever is returned. A node has nothing to close by then, so that it may end at once.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ORDERLY = (["node"], ["replay"], ["echo"])
"""Commands that an interrupt ends in order."""


@contextmanager
def loading(given: list[str]) -> Iterator[None]:
    """End a node with status 0 at an interrupt, until ``loaded`` is called or the block ends."""
    handled = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    here = threading.current_thread() is threading.main_thread()
    if not (handled and here and given[:1] in ORDERLY and "--simulate-again" not in given):
        yield
        return
    signal.signal(signal.SIGINT, _end)
    try:
        yield
    finally:
        loaded()


def loaded() -> None:
    """Have interrupts raise KeyboardInterrupt again."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number: int, frame: FrameType | None) -> None:
    os._exit(0)
