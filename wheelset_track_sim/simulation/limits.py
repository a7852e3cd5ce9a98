"""What a run cannot hold, said when it starts: waves that pass too slowly, and steps that are too long."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..errors import warn
from ..irregularities import rail_heights, tread_heights
from ..irregularities.surface import WHEELS
from ..runtime.arrays import Real
from ..scenario import Scenario
from ..scenario.scenario import dividing
from ..track.supports import FOLLOWED_STEP
from ..wheelset.reduced import ReducedWheelset

HELD_TOPS, HELD_BODY = 15.0, 3.0
"""Frequencies, Hz, below which the bogie frame moves, and the car body: what is held there makes forces of its own."""
MATTERS = 0.01
"""Share of the wheel load from which on such a force is named."""


class Slow(NamedTuple):
    """Waves of a surface that pass below a frequency."""

    amplitude: float
    """m, of one wave with their mean square."""
    wavelength: float
    """m, of the highest of them."""


def warn_of_limits(scenario: Scenario, reduced: ReducedWheelset) -> None:
    """Issue an InputWarning for what the models of a scenario do not hold at its lowest speed."""
    events = [event.speed for event in scenario.events if event.speed is not None]
    speed = min([scenario.speed, *(point.speed for point in scenario.speed_plan), *events])
    _warn_of_steps(scenario, speed)
    vehicle = scenario.vehicle
    if vehicle is None:
        _warn_of_slow_waves(scenario, reduced, speed, HELD_TOPS, "the suspension's upper ends", "a vehicle")
    elif vehicle.body_mass is None:
        _warn_of_slow_waves(scenario, reduced, speed, HELD_BODY, "the car body", "vehicle.body_mass")


def _warn_of_steps(scenario: Scenario, speed: float) -> None:
    track, dx = scenario.track, scenario.step_length
    if track.line is None or not scenario.irregularities or dx <= FOLLOWED_STEP * speed * (1 + 1e-9):
        return
    finer = dividing(track.spacing, math.ceil(track.spacing / (FOLLOWED_STEP * speed) - 1e-9))
    warn(
        f"speed = {speed:g} m/s makes steps of {1e6 * dx / speed:.3g} us, and track.line follows impacts up to "
        f"{1e6 * FOLLOWED_STEP:.3g} us: peaks may be 12 % too high, give a step_length of {finer} m"
    )


def _warn_of_slow_waves(
    scenario: Scenario, reduced: ReducedWheelset, speed: float, below: float, held: str, remedy: str
) -> None:
    stiffness = 1.0 / float(reduced.static_receptance().sum(axis=1).mean())
    for surface in sorted({item.on for item in scenario.irregularities}):
        heights, dx = _heights(scenario, surface), scenario.step_length
        slow = slow_waves(heights, dx, speed / below)
        force = stiffness * slow.amplitude
        if force > MATTERS * scenario.wheel_load:
            warn(
                f"{surface} has waves of {slow.wavelength:.3g} m and {1e3 * slow.amplitude:.3g} mm in amplitude, "
                f"which pass at {speed / slow.wavelength:.3g} Hz: {held} cannot be held below {below:g} Hz, where that "
                f"makes {force / 1e3:.3g} kN of a wheel load of {scenario.wheel_load / 1e3:.4g} kN: give {remedy}"
            )


def slow_waves(heights: Real, dx: float, longer: float) -> Slow:
    """Waves in the heights (steps,), m, of a surface that repeats, from a length on, m; constant heights are none."""
    length = len(heights) * dx
    count = min(math.ceil(length / longer - 1e-9), (len(heights) + 1) // 2)
    if count < 2:
        return Slow(0.0, length)
    amplitudes = 2.0 / len(heights) * np.abs(np.fft.rfft(heights)[1:count])
    return Slow(float(np.sqrt(np.sum(amplitudes**2))), length / (1 + int(amplitudes.argmax())))


def _heights(scenario: Scenario, surface: str) -> Real:
    """Heights (steps,), m, in the middle of a tread or rail."""
    middle, dx = np.zeros(1), scenario.step_length
    if surface in WHEELS:
        return tread_heights(scenario.irregularities, surface, scenario.steps_per_revolution, dx, middle)[:, 0]
    return rail_heights(scenario.irregularities, surface, scenario.line_steps, dx, middle).all()[:, 0]
