"""How wheel and rail press on each other: what a scenario says of the contact beside profiles and irregularities."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..inputs.schema import check, quantity


@dataclass(frozen=True)
class ContactOptions:
    """How wheel and rail press on each other. The default is the linear elastic contact of the paper."""

    hardness: float | None = quantity("Pa", 1e9, 2e10, "the hardness of wheel and rail", default=None)
    """Largest pressure that the softer of wheel and rail withstands, Pa; None is an elastic contact without a bound."""

    tolerance: float = quantity(
        "", 1e-6, 0.01, "the largest estimated error of a filtered force, share of the static load", default=0.001
    )
    """Beyond it, the contact of the step is solved."""
    exact: bool = False
    """Whether all contacts without a force table are solved; with a hardness they are in any case."""

    def __post_init__(self) -> None:
        check(self, "contact")

    @property
    def largest_pressure(self) -> float:
        """The hardness, Pa; infinite without one."""
        return math.inf if self.hardness is None else self.hardness

    @property
    def largest_estimate(self) -> float:
        """The tolerance; 0 where nothing is filtered."""
        return 0.0 if self.exact or self.hardness is not None else self.tolerance
