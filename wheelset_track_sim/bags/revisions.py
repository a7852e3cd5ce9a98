"""Changes of a recorded run, and what was changed by each."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from ..errors import InputError
from ..inputs.yaml12 import parse
from .inputs import Input


class Difference(NamedTuple):
    """One key of a scenario that a change set; None stands for a key that is not there."""

    key: str
    """Dotted path, such as ``irregularities.0.h``."""
    before: Any
    after: Any


@dataclass(frozen=True)
class Revision:
    """A change that has come into force."""

    number: int
    step: int
    """From which it is in force."""
    differences: tuple[Difference, ...]
    """From the revision before that the bag knows."""


def revisions(inputs: Iterable[Input]) -> tuple[Revision, ...]:
    """Revisions in their order, each once: a state is told again where a file begins."""
    first: dict[int, Input] = {}
    for found in sorted(inputs, key=lambda found: (found.revision, found.step)):
        first.setdefault(found.revision, found)
    known = [*first.values()]
    return tuple(
        Revision(now.revision, now.step, differences(before.scenario, now.scenario) if before else ())
        for before, now in pairwise([None, *known])
        if now is not None
    )


def differences(before: str, after: str) -> tuple[Difference, ...]:
    """Keys in which two scenarios differ, which are YAML texts."""
    # A scenario holds the descriptions of its models: only what differs is parsed.
    old, new = _sections(before), _sections(after)
    texts = ["".join(part for part in one if part not in other) for one, other in ((old, new), (new, old))]
    try:
        return tuple(_differences("", *(parse(text, "scenario") or {} for text in texts)))
    except InputError:  # of another version or by hand
        return (Difference("scenario", before, after),) if before != after else ()


def _sections(text: str) -> list[str]:
    """A YAML mapping by its uppermost keys."""
    return re.split(r"(?m)^(?=[^\s#-])", text)


def _differences(key: str, before: Any, after: Any) -> Iterable[Difference]:
    if isinstance(before, dict) and isinstance(after, dict):
        names = [*before, *(name for name in after if name not in before)]
    elif isinstance(before, list) and isinstance(after, list):
        names = [*range(max(len(before), len(after)))]
        before, after = dict(enumerate(before)), dict(enumerate(after))
    elif before != after:
        yield Difference(key.removeprefix("."), before, after)
        return
    else:
        return
    for name in names:
        yield from _differences(f"{key}.{name}", before.get(name), after.get(name))
