"""How every command ends: its exit status, and one line on standard error for whatever stopped it.

Also what comes from around the program ends here: a reader that is gone, a full disk, paths that cannot be used.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from pathlib import Path
from typing import Any

from ..errors import InputError, WheelsetTrackError, printable

FAILED, REFUSED = 1, 2
OF_PATHS = (
    *(errno.ENOENT, errno.EISDIR, errno.ENOTDIR, errno.EACCES, errno.EPERM, errno.EROFS, errno.EEXIST),
    *(errno.ENAMETOOLONG, errno.ELOOP),
)
"""Errors that another path helps against."""


class _OutputError(Exception):
    """Standard output cannot be written. No OSError, which libraries take for theirs and swallow."""

    def __init__(self, reason: OSError) -> None:
        super().__init__(str(reason))
        self.reason = reason


class _Output:
    """A stream that marks its own errors."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        written: int = self._told(self._stream.write, text)
        return written

    def flush(self) -> None:
        self._told(self._stream.flush)

    def _told(self, call: Callable[..., Any], *arguments: str) -> Any:
        try:
            return call(*arguments)
        except OSError as reason:
            raise _OutputError(reason) from reason


def status_of(command: Callable[[], int], program: str, interrupted: int = FAILED) -> int:
    """Run a command; returns its exit status, and ``interrupted`` if it was interrupted before it ended."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, ValueError):  # of a test, or closed
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    try:
        _require_folder()
        if sys.stdout is None:
            return command()
        output: Any = _Output(sys.stdout)
        with redirect_stdout(output):
            try:
                return command()
            finally:
                output.flush()
    except InputError as refusal:
        return complain(program, refusal, REFUSED)
    except WheelsetTrackError as failure:
        return complain(program, failure, FAILED)
    except UnicodeEncodeError as reason:
        name = reason.object[max(0, reason.start - 40) : reason.end + 40]
        return complain(program, f"{name!r} is not UTF-8: rename the file, or give another name", REFUSED)
    except _OutputError as failure:
        _discard(sys.stdout)
        if isinstance(failure.reason, BrokenPipeError):  # the reader has seen enough
            return FAILED
        why = f"standard output cannot be written ({failure.reason.strerror}): make room, or send it elsewhere"
        return complain(program, why, FAILED)
    except OSError as reason:
        return _surroundings(program, reason)
    except MemoryError:
        return complain(program, "there is not enough memory: give a smaller input, or a higher limit", FAILED)
    except KeyboardInterrupt:
        return interrupted if interrupted == 0 else complain(program, "interrupted", interrupted)


def complain(program: str, reason: object, status: int) -> int:
    """Print a line on standard error, if that can be written; returns ``status``."""
    try:
        print(f"{program}: {printable(' '.join(str(reason).split()))}", file=sys.stderr, flush=True)  # noqa: T201
    except OSError:
        _discard(sys.stderr)
    return status


def _require_folder() -> None:
    try:
        Path.cwd()
    except OSError:
        raise InputError("the working folder has been removed: change to one that exists") from None


def _surroundings(program: str, reason: OSError) -> int:
    """Say what the system refused."""
    why, path = reason.strerror or str(reason), reason.filename
    if path is None or reason.errno not in OF_PATHS:
        where = "" if path is None else f"{os.fsdecode(path)}: "
        return complain(program, f"{where}{why}: remove the cause, and try again", FAILED)
    return complain(program, f"{os.fsdecode(path)} cannot be used ({why}): give another path", REFUSED)


def _discard(stream: Any) -> None:
    """Send what is left of a stream nowhere: Python would complain of it in the end."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
