"""What a run reached, compared with a set of limits: a verdict for each wheel, damage and stress node.

Each quantity is compared with limits of the same quantity only. A contact force is the largest one of the wheel. The
length of damage is that along the tread. A limit of axle stress holds for the bending amplitude, which a point of the
turning axle goes through, and not for the largest principal stress at a node that stands still.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..inputs import units
from ..irregularities.surface import WHEELS
from .limit_set import Level, Limit, LimitSet

FORCE, LENGTH, AMPLITUDE = "contact_force", "damage_length", "bending_amplitude"
WORDS = {FORCE: "largest contact force", LENGTH: "length of tread damage", AMPLITUDE: "bending amplitude"}
UNITS = {FORCE: "N", LENGTH: "m", AMPLITUDE: "Pa"}


@dataclass(frozen=True)
class Verdict:
    """One value against the limits of its quantity."""

    subject: str
    """Wheel or stress node."""
    quantity: str
    """``contact_force``, ``damage_length`` or ``bending_amplitude``."""
    value: float
    """SI."""
    limit: Limit
    """The most severe limit that is exceeded, or the lowest one."""
    limits: str
    """Name of the set."""

    @property
    def exceeded(self) -> bool:
        """Whether the value is above the limit."""
        return self.value > self.limit.above

    @property
    def level(self) -> Level:
        """OK, or that of the limit."""
        return self.limit.severity if self.exceeded else Level.OK

    @property
    def text(self) -> str:
        """What is compared with which limit, and what to do if it is exceeded, in one line for people."""
        shown = units.for_people(UNITS[self.quantity])
        value, limit = (f"{each / shown.size:.4g} {shown.name}" for each in (self.value, self.limit.above))
        words = f"{self.subject.replace('_', ' ')}: {WORDS[self.quantity]} {value}"
        if self.exceeded:
            return f"{words} is above {limit}: {self.limit.action} ({self.limits})"
        return f"{words} is within {limit} ({self.limits})"

    @property
    def mapping(self) -> dict[str, Any]:
        """The same for programs, SI."""
        unit = UNITS[self.quantity]
        return {
            "subject": self.subject,
            "compared": self.quantity,
            "level": self.level.word,
            f"value_{unit}": self.value,
            f"limit_{unit}": self.limit.above,
            "action": self.limit.action if self.exceeded else "",
            "source": self.limit.source,
        }


def verdicts(
    limits: LimitSet,
    forces: Sequence[float],
    irregularities: Iterable[Any] = (),
    amplitudes: Mapping[str, float] | None = None,
) -> tuple[Verdict, ...]:
    """Compare what a run reached with a set of limits.

    Parameters
    ----------
    limits
        The set. What it has no limit for is not compared.
    forces
        Largest contact force of each wheel, N.
    irregularities
        Of the run, as objects or as plain mappings.
    amplitudes
        Largest bending amplitude of stress nodes, Pa; NaN and nodes that are missing are not compared.

    Returns
    -------
    tuple of Verdict
        Wheels first, then nodes.
    """
    lengths = damage_lengths(irregularities)
    compared: list[tuple[str, str, float, tuple[Limit, ...]]] = [
        *((wheel, FORCE, force, limits.force) for wheel, force in zip(WHEELS, forces, strict=True)),
        *((wheel, LENGTH, length, limits.damage_length) for wheel, length in lengths.items()),
        *(
            (node, AMPLITUDE, amplitude, tuple(limit for limit in limits.axle if node in limit.nodes))
            for node, amplitude in (amplitudes or {}).items()
        ),
    ]
    return tuple(
        Verdict(subject, quantity, value, _decisive(value, those), limits.name)
        for subject, quantity, value, those in compared
        if those and math.isfinite(value)
    )


def worst(found: Iterable[Verdict]) -> Level:
    """The highest level of all."""
    return max((each.level for each in found), default=Level.OK)


def damage_lengths(irregularities: Iterable[Any]) -> dict[str, float]:
    """Length along the tread of the longest breakout or flat of each wheel that has one, m.

    Other kinds, such as polygons and measured treads, have no length of their own.
    """
    found: dict[str, float] = {}
    for item in irregularities:
        values = item if isinstance(item, Mapping) else {"type": item.type, **vars(item)}
        length = _length(values)
        if length > 0 and values.get("on") in WHEELS:
            found[values["on"]] = max(length, found.get(values["on"], 0.0))
    return dict(sorted(found.items()))


def _length(values: Mapping[str, Any]) -> float:
    if values.get("type") == "breakout":
        return 2 * float(values["a"])
    if values.get("type") == "flat":
        return float(values.get("worn_length") or values["length"])
    return 0.0


def _decisive(value: float, limits: Sequence[Limit]) -> Limit:
    """Of the limits that a value exceeds the most severe and then highest one; the lowest one if it exceeds none."""
    exceeded = [limit for limit in limits if value > limit.above]
    if exceeded:
        return max(exceeded, key=lambda limit: (limit.severity, limit.above))
    return min(limits, key=lambda limit: limit.above)
