"""What every sensor has: its sampling, range, noise and seed."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any, Self

from ..errors import InputError
from ..inputs.schema import check, quantity

NAME = re.compile(r"[a-z](_?[a-z0-9])*")
LONGEST_NAME = 60
TRUE = "true"
"""Last part of the topic of true values."""


@dataclass(frozen=True)
class Acquisition:
    """How a sensor samples; a sensor adds its ``range``, ``noise`` and ``drift`` in its own unit.

    Without ``rate`` the sensor gives a sample at every step, and its true value if it has no ``range`` either.
    """

    rate: float | None = quantity("Hz", 100.0, 1e6, "the sampling rate", default=None)
    """Samples a second at whole multiples of its inverse since step 0, through a low pass of half of it."""
    seed: int = quantity("", 0, 2**31 - 1, "the seed of the noise", default=0)
    true_value: bool = False
    """Also record the true value at every step."""

    def __post_init__(self) -> None:
        check(self)
        own: Any = self
        for name in ("noise", "drift"):
            if getattr(own, name) and self.rate is None:
                raise InputError(f"{name} needs a sampling rate, which bounds its band: give rate, Hz")

    @property
    def ideal(self) -> bool:
        """Whether a sample is the true value of its step."""
        own: Any = self
        return self.rate is None and own.range is None

    @property
    def silent(self) -> Self:
        """The same without noise and drift, which can change during a run."""
        without: dict[str, Any] = {"noise": 0.0, "drift": 0.0}
        return replace(self, **without)


def check_name(name: str) -> None:
    """Raise InputError for a name that cannot be part of a topic."""
    if not NAME.fullmatch(name) or len(name) > LONGEST_NAME or name == TRUE:
        raise InputError(
            f"name = {name!r} cannot name a topic: give at most {LONGEST_NAME} lower-case letters, digits and single "
            f"underscores between them, a letter first, and not {TRUE}"
        )
