"""YAML 1.2, where ``on`` is a key and not a truth value, and ``1e-3`` a number and not a text."""

from __future__ import annotations

from collections.abc import Iterable
from io import StringIO
from typing import Any

from ruamel.yaml import YAML, version_info
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent

from ..errors import InputError

DEEPEST = 20
"""Lists and mappings in one another, in a text that is not trusted."""
DIGITS = 30
LARGEST = 10**DIGITS
"""Largest whole number."""
UNFOLDED = 1 << 30
"""Width of lines, characters."""
MOST_VALUES = 2_000_000
"""Values of a text."""


def parse(text: str, where: str, *, trusted: bool = True) -> Any:
    """Plain value of a YAML text; raises InputError naming ``where`` if it is not YAML.

    One that is not ``trusted`` is refused if it holds aliases, by which a short text can stand for a huge value, or is
    nested more than ``DEEPEST`` times, which takes long to read.
    """
    try:
        if not trusted:
            _check_events(YAML(typ="safe", pure=True).parse(text), where)
        found = YAML(typ="safe", pure=True).load(text)
        _check_values(found, where)
        return found
    except InputError:
        raise
    except RecursionError:
        raise InputError(f"{where} is nested too deeply: give a flatter one") from None
    except DuplicateKeyError as reason:
        line = f", line {reason.problem_mark.line + 1}" if reason.problem_mark else ""
        raise InputError(f"{where}{line}: {reason.problem}: give it once") from None
    except YAMLError as reason:
        raise InputError(f"{where} is not YAML ({' '.join(str(reason).split())}): correct it there") from None
    except ValueError as reason:  # a date or number that looks like one and is none
        raise InputError(f"{where} is not YAML ({reason}): correct it there") from None


def _check_values(value: Any, where: str) -> None:
    """Refuse more values than a file can mean, as aliases make them, and whole numbers that no quantity can have."""
    left, seen = [value], 0
    while left:
        item = left.pop()
        seen += 1
        if seen > MOST_VALUES:
            raise InputError(f"{where} holds more than {MOST_VALUES} values: give a smaller one without aliases")
        if isinstance(item, dict):
            left += [*item, *item.values()]
        elif isinstance(item, list):
            left += item
        elif isinstance(item, int) and abs(item) > LARGEST:
            raise InputError(f"{where} has a whole number of {len(str(abs(item)))} digits: give up to {DIGITS}")


def _check_events(events: Iterable[Any], where: str) -> None:
    depth = 0
    for event in events:
        depth += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)
        if isinstance(event, AliasEvent):
            raise InputError(f"{where} holds an alias (*): write out its content")
        if depth > DEEPEST:
            raise InputError(f"{where} is nested more than {DEEPEST} times: give a flatter one")


def dump(value: Any) -> str:
    """A plain value as YAML text; ``parse`` gives it back, floats bit by bit."""
    out = StringIO()
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False
    if version_info < (0, 19):  # folds a long text after a line break in it, and reads it with a space more
        yaml.width = UNFOLDED
    yaml.dump(value, out)
    return out.getvalue()
