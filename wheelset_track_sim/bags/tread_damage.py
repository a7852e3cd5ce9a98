"""Tread damage in messages: encode and decode."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..errors import InputError
from ..irregularities import Breakout, Irregularity
from ..irregularities.kinds import MOST
from ..scenario import WHEELS

KINDS: dict[int, type[Breakout]] = {0: Breakout}
"""Irregularities by the number of their kind in ``TreadDamage``."""
NUMBERS = ("a", "b", "h", "angle", "y")
FIELDS = ("wheel", "kind", *NUMBERS)
"""Fields of ``TreadDamage``."""


def damage_fields(irregularities: Iterable[Irregularity]) -> tuple[Mapping[str, float], ...]:
    """``FIELDS`` of each breakout; other irregularities are in the scenario alone."""
    return tuple(
        {"wheel": WHEELS.index(item.on) + 1, "kind": 0} | {name: getattr(item, name) for name in NUMBERS}
        for item in irregularities
        if isinstance(item, Breakout)
    )


def irregularities_of(damage: Sequence[Any]) -> tuple[Breakout, ...]:
    """Irregularities from messages ``TreadDamage``, without any of depth 0; InputError names the first bad field."""
    if len(damage) > MOST:
        raise InputError(f"damage has {len(damage)} entries: give at most {MOST}")
    return tuple(found for found in (_irregularity(index, item) for index, item in enumerate(damage)) if found.h > 0)


def _irregularity(index: int, item: Any) -> Breakout:
    where = f"damage.{index}"
    if not 1 <= item.wheel <= len(WHEELS):
        raise InputError(f"{where}.wheel = {item.wheel} is not a wheel: give 1 (far from the gearbox) or 2")
    if item.kind not in KINDS:
        known = ", ".join(f"{number} ({kind.type})" for number, kind in KINDS.items())
        raise InputError(f"{where}.kind = {item.kind} is not a kind of damage: known are {known}")
    try:
        return KINDS[item.kind](on=WHEELS[item.wheel - 1], **{name: getattr(item, name) for name in NUMBERS})
    except InputError as refusal:
        raise InputError(f"{where}.{refusal}") from None
