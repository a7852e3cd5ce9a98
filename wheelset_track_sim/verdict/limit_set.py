"""Sets of limits of forces, tread damage and axle stress, each with what to do above it and its source."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Literal, TypeAlias

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, quantity, read

NO_LIMITS = "none"
"""The name that means no set."""
DEFAULT_LIMITS = "trafikverket"


class Level(IntEnum):
    """How bad it is; numbers as in ``diagnostic_msgs/DiagnosticStatus``."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3

    @property
    def word(self) -> str:
        """The level as people read it."""
        return ("ok", "warning", "alarm", "stale")[self]


@dataclass(frozen=True)
class StatedLimit:
    """What every limit has beside its number."""

    level: Literal["warning", "alarm"]
    """What a value above the limit is."""
    action: str
    """What the source demands then."""
    source: str

    def __post_init__(self) -> None:
        check(self)
        if not self.action.strip():
            raise InputError("action is empty: say what to do above the limit")
        if not self.source.strip():
            raise InputError("source is empty: say where the limit comes from")

    @property
    def severity(self) -> Level:
        """The level as a number."""
        return Level.WARN if self.level == "warning" else Level.ERROR


@dataclass(frozen=True)
class ForceLimit(StatedLimit):
    """Limit of the largest contact force of a wheel."""

    above: float = quantity("N", 1e3, 5e6, "the contact force", usual=(5e4, 2e6))


@dataclass(frozen=True)
class LengthLimit(StatedLimit):
    """Limit of the length of tread damage along the circumference."""

    above: float = quantity("m", 1e-3, 1.0, "the length of the damage")


@dataclass(frozen=True)
class StressLimit(StatedLimit):
    """Limit of the bending amplitude at stress nodes in one zone of an axle of one steel grade."""

    zone: str
    """Part of the axle for which the source gives the limit, such as ``body`` or ``seat``."""
    grade: str
    """Steel grade, such as ``EA1N``."""
    nodes: tuple[str, ...]
    """Stress nodes in that zone."""
    above: float = quantity("Pa", 1e5, 2e9, "the bending amplitude", usual=(1e7, 2e9))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.nodes:
            raise InputError("nodes is empty: name the stress nodes in the zone, such as [A1]")


Limit: TypeAlias = ForceLimit | LengthLimit | StressLimit


@dataclass(frozen=True)
class LimitSet:
    """Limits of one infrastructure manager or railway; each list may be empty.

    Examples
    --------
    >>> [limit.above for limit in load_limits("trafikverket").force]
    [350000.0]
    """

    name: str
    force: tuple[ForceLimit, ...] = ()
    damage_length: tuple[LengthLimit, ...] = ()
    axle: tuple[StressLimit, ...] = ()

    def __post_init__(self) -> None:
        if not (self.force or self.damage_length or self.axle):
            raise InputError(f"limits {self.name!r} are empty: give force, damage_length or axle")


def load_limits(source: str | Path) -> LimitSet | None:
    """Load a set of limits.

    Parameters
    ----------
    source
        Name of a shipped set (``trafikverket``, ``fra``, ``network_rail``, ``own``), path of a YAML file, or ``none``.

    Returns
    -------
    LimitSet or None
        None for ``none``.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.
    """
    return None if source == NO_LIMITS else read(LimitSet, shipped.load_yaml("limits", source), "")
