"""Limits from which on something is worth a look, or an alarm."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError
from ..inputs.schema import check, quantity

IN_ORDER = (("stress_warn", "stress_error"), ("lag_warn", "lag_error"), ("pace_error", "pace_warn"))
"""Limits of which the first must not be above the second."""


@dataclass(frozen=True)
class Limits:
    """Limits of loads, stresses and pace; ``docs/howto/monitoring.md`` has the sources of the defaults.

    The force that is worth a look is that which makes an impact (``ImpactSettings.threshold``).
    """

    force_error: float = quantity("N", 1e3, 5e6, "the contact force that is an alarm", default=350e3)
    stress_warn: float = quantity("Pa", 1e5, 2e9, "the bending amplitude that is a warning", default=166e6)
    stress_error: float = quantity("Pa", 1e5, 2e9, "the bending amplitude that is an alarm", default=200e6)
    lag_warn: float = quantity("s", 0.0, 3600.0, "the time behind the schedule that is a warning", default=0.2)
    lag_error: float = quantity("s", 0.0, 3600.0, "the time behind the schedule that is an alarm", default=2.0)
    pace_warn: float = quantity(
        "", 0.0, 1.0, "the share of the required real-time factor below which pacing is a warning,", default=0.9
    )
    pace_error: float = quantity(
        "", 0.0, 1.0, "the share of the required real-time factor below which pacing is an alarm,", default=0.5
    )
    stale_after: float = quantity(
        "s", 0.1, 3600.0, "the time without a sample after which everything is stale", default=10.0
    )

    def __post_init__(self) -> None:
        check(self)
        for lower, upper in IN_ORDER:
            if getattr(self, lower) > getattr(self, upper):
                raise InputError(
                    f"{lower} = {getattr(self, lower):g} is above {upper} = {getattr(self, upper):g}: "
                    f"give a {lower} of at most that"
                )
