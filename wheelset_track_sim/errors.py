"""The family of errors that a caller can act on, and warnings about input; everything else keeps its traceback."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

LONGEST = 2000
"""Characters of a line that refuses input, or warns of it."""


class WheelsetTrackError(Exception):
    """Base of all errors raised on purpose by this package; the command line ends with status 1.

    The message is one line. It may quote what comes from files or over a network: characters that cannot be printed are
    escaped (``printable``), and a message that is longer than ``LONGEST`` loses its middle.
    """

    def __init__(self, message: object = "") -> None:
        super().__init__(_line(str(message)))


class InputError(WheelsetTrackError, ValueError):
    """Input that cannot be used; the command line ends with status 2.

    The message names quantity, value, limit and remedy.
    """


class InputWarning(UserWarning):
    """Input that is used although it looks wrong: one line with quantity, value, limit and remedy, as in InputError.

    The command line prints the line on standard error and continues; ``--json`` lists it in ``"warnings"``. In Python,
    filter it like every warning.

    Examples
    --------
    >>> import warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", InputWarning)  # stop at what looks wrong
    ...     scenario = load_scenario("undamaged")
    """


_recorded: ContextVar[bool] = ContextVar("recorded", default=False)


@contextmanager
def recorded_input() -> Iterator[None]:
    """Take input within as that of a recorded run.

    What it was warned of when it was fresh is not repeated. What ``doubt`` refuses today was simulated then, so that it
    is used again with a warning.
    """
    token = _recorded.set(True)
    try:
        yield
    finally:
        _recorded.reset(token)


def warn(message: str) -> None:
    """Issue an InputWarning about new input: quantity, value, limit and remedy in one line."""
    if not _recorded.get():
        warnings.warn(_line(message), InputWarning, stacklevel=3)


def doubt(message: str) -> None:
    """Raise InputError for fresh input that can be used and cannot be meant; warn of it in that of a recorded run."""
    if not _recorded.get():
        raise InputError(message)
    warnings.warn(_line(f"as recorded: {message}"), InputWarning, stacklevel=3)


def printable(text: str) -> str:
    """Text in one line that does nothing to a terminal, whatever file or network it comes from.

    Characters that cannot be printed are escaped as in Python: control characters, those that change the direction of
    text, and bytes of file names that are not UTF-8.
    """
    return text if text.isprintable() else "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)


def _line(message: str) -> str:
    line = printable(message)
    half = (LONGEST - 5) // 2
    return line if len(line) <= LONGEST else f"{line[:half]} ... {line[-half:]}"


class ContactError(WheelsetTrackError):
    """The contact problem of a step has no solution within the iteration bound, or is not finite."""


class RecordingError(WheelsetTrackError):
    """A bag cannot be written or read; the message is a line like that of InputError."""

    def __init__(self, message: str) -> None:
        super().__init__(_line(message))


class NoBagError(RecordingError, InputError):
    """There is no bag where one was said to be."""


class DivergenceError(WheelsetTrackError):
    """Forces, displacements or stresses of a step are not finite."""
