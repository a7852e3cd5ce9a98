"""What was measured of one passage or some turns: a peak alone or a signal over time, and how exact it is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..errors import InputError
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real
from ..scenario.scenario import Wheel

Signal = Literal["force", "box"]
NOISE: dict[Signal, float] = {"force": 2e3, "box": 2.0}
"""Standard deviation of a sample if none is given: N, m/s^2."""
FEWEST = 32
"""Samples of an observation."""
BEFORE, AFTER = 0.5, 1.2
"""Track before and after the peak of a single hit that is used, m."""
TURNS = 3
"""Turns that are used of a signal of the wheelset."""
LEAD = 0.2
"""Track before the first hit that is used of it, m."""
SHAPE: dict[Signal, float] = {"force": 0.02, "box": 0.05}
"""Standard deviation of errors of the model that the track does not explain, as a share of how far a sample is from the
median. At the peak of a force, variants of the model at lag zero differ by some 3 % (``docs/validation.md``). What the
wheelset does after a hit rings on, and phases drift apart."""


@dataclass(frozen=True)
class PeakReading:
    """The largest contact force of one passage, and nothing else.

    Examples
    --------
    >>> reading = PeakReading(force=250e3, speed=25.0, axle_load=220e3)
    >>> f"{reading.spread / 1e3:.1f} kN"  # of noise and gain
    '7.8 kN'
    """

    force: float = quantity("N", 1e4, 2e6, "the peak force", usual=(5e4, 1e6))
    speed: float = quantity("m/s", 5.0, 100.0, "the speed", default=27.7777778, usual=(5.0, 100.0))
    axle_load: float = quantity("N", 2e4, 4e5, "the axle load", default=196200.0, usual=(2e4, 4e5))
    noise: float = quantity("N", 0.0, 1e5, "the standard deviation of the reading", default=NOISE["force"])
    gain_error: float = quantity("", 0.0, 0.5, "the standard deviation of the gain", default=0.03)

    def __post_init__(self) -> None:
        check(self)
        if self.force <= self.axle_load / 2:
            raise InputError(
                f"force = {self.force:g} N is not above the static wheel load of {self.axle_load / 2:g} N: "
                "give the peak of a damaged wheel, or the right axle load"
            )

    @property
    def spread(self) -> float:
        """Standard deviation of the reading about the true peak, N."""
        return math.hypot(self.noise, self.gain_error * self.force)


@dataclass(frozen=True, eq=False)
class Observation:
    """A signal over time of one passage, or of a wheelset over some turns.

    Raises
    ------
    InputError
        For too few samples, or samples that are not finite or not at even times.

    Examples
    --------
    >>> block = Passages(load_scenario("undamaged")).run(load_scenario("flat_fresh").irregularities)
    >>> import numpy as np
    >>> time = block.step_period * np.arange(len(block))
    >>> Observation("force", time, block.forces[:, 0], speed=block.speed, noise=3e3).wheel
    'wheel_1'
    """

    signal: Signal
    """``force``: contact force of one wheel, N. ``box``: acceleration of its axle box, m/s^2."""
    time: Real
    """(n,) s, increasing at even steps."""
    values: Real
    """(n,) SI units."""
    source: str = "data"
    wheel: Wheel = "wheel_1"
    speed: float = quantity("m/s", 5.0, 100.0, "the speed", default=27.7777778, usual=(5.0, 100.0))
    axle_load: float = quantity("N", 2e4, 4e5, "the axle load", default=196200.0, usual=(2e4, 4e5))
    noise: float | None = quantity("", 1e-9, 1e6, "the standard deviation of a sample", default=None)
    """Of white noise, in the unit of the values; None for ``NOISE``."""
    shape_error: float | None = quantity("", 0.0, 0.5, "the error of the model beside that of the track", default=None)
    """As a share of how far a sample is from the median; None for ``SHAPE``."""
    gain_error: float = quantity("", 0.0, 0.5, "the standard deviation of the gain", default=0.03)
    speed_error: float = quantity("", 0.0, 0.1, "the standard deviation of the speed as a share of it", default=0.005)

    def __post_init__(self) -> None:
        check(self)
        if len(self.time) != len(self.values) or len(self.time) < FEWEST:
            raise InputError(
                f"{self.source} has {len(self.time)} times and {len(self.values)} values: give {FEWEST} of each or more"
            )
        if not (np.isfinite(self.time).all() and np.isfinite(self.values).all()):
            raise InputError(f"{self.source} has values that are not finite: give numbers, or a part that has them")
        steps = np.diff(self.time)
        if not (steps > 0).all() or np.ptp(steps) > 0.02 * steps.mean():
            raise InputError(f"{self.source} is not sampled at even times: resample it, or give a part without gaps")

    @property
    def sigma(self) -> float:
        """Standard deviation of the noise of a sample."""
        return NOISE[self.signal] if self.noise is None else self.noise

    @property
    def shape(self) -> float:
        """Standard deviation of other errors of the model, as a share of how far a sample is from the median."""
        return SHAPE[self.signal] if self.shape_error is None else self.shape_error

    @property
    def period(self) -> float:
        """Time from sample to sample, s."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)

    @property
    def on_wheelset(self) -> bool:
        """Whether a sensor of the wheelset gave it, which sees every turn."""
        return self.signal != "force"

    @property
    def peak(self) -> int:
        """Sample from which places are counted: where the signal is farthest from its median."""
        return int(np.abs(self.values - np.median(self.values)).argmax())

    def window(self, circumference: float) -> tuple[int, int, int]:
        """First sample, peak, and sample after the last one that are used."""
        reach = (TURNS * circumference, TURNS * circumference) if self.on_wheelset else (BEFORE, AFTER)
        peak = self.peak
        first, end = (round(length / (self.speed * self.period)) for length in reach)
        if self.on_wheelset:  # whole turns in all, the peak among them
            lead, turn = (length / (self.speed * self.period) for length in (LEAD, circumference))
            behind = min(max(1, int((len(self.values) - peak + lead) // turn)), TURNS)
            before = min(TURNS - behind, int(max(0.0, peak - lead) // turn))
            first, end = round(before * turn + lead), round(behind * turn - lead)
        return max(0, peak - first), peak, min(len(self.values), peak + end)
