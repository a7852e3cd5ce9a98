"""How wheel and rail press on each other: what a scenario says of the contact beside profiles and irregularities."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..inputs.schema import check, quantity


@dataclass(frozen=True)
class ContactOptions:
    """How wheel and rail press on each other. The default is the linear elastic contact of the paper."""

    hardness: float | None = quantity("Pa", 1e9, 2e10, "the hardness of wheel and rail", default=None)
    """Largest pressure that the softer of wheel and rail bears, Pa; None is an elastic contact without a bound."""

    def __post_init__(self) -> None:
        check(self, "contact")

    @property
    def largest_pressure(self) -> float:
        """The hardness, Pa; infinite without one."""
        return math.inf if self.hardness is None else self.hardness
