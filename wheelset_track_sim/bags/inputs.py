"""All that went into a run, as a bag keeps it: what it started under, and every change with the step it came at.

Each file of a bag begins with what went in up to there. So a part of a bag, or a recording that was started late, can
be simulated again from step 0 on as well as a whole one.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable
from typing import NamedTuple

MOST = 10_000
"""Changes that a file begins with at most, the latest."""


class Input(NamedTuple):
    """A change that has come into force; revision 0 is the start."""

    revision: int
    step: int
    """From which it is in force."""
    scenario: str
    """As YAML."""


def with_input(inputs: tuple[Input, ...], new: Input) -> tuple[Input, ...]:
    """``inputs`` with one more behind them, unless they have it already; the earliest are left out beyond ``MOST``."""
    return (*inputs, new)[-MOST:] if not inputs or new.revision > inputs[-1].revision else inputs


def encoded(inputs: Iterable[Input]) -> str:
    """Inputs as text: JSON, compressed, in base64, for the scenarios of a run are much alike."""
    return base64.b64encode(zlib.compress(json.dumps([*inputs]).encode())).decode()


def decoded(text: str) -> tuple[Input, ...]:
    """Inputs from their text; ValueError if it is not one."""
    try:
        return tuple(
            Input(int(revision), int(step), str(scenario))
            for revision, step, scenario in json.loads(zlib.decompress(base64.b64decode(text, validate=True)))
        )
    except (ValueError, TypeError, zlib.error) as reason:
        raise ValueError(f"inputs of the run cannot be read: {reason}") from reason
