"""Whether measured loads can be those of a wheel on a rail, and what else they look like."""

from __future__ import annotations

import numpy as np

from ...errors import InputError, warn
from ...runtime.arrays import Real
from .measurement import WHEELS, Measurement

LOADS = (5e3, 300e3)
"""Mean loads of wheels, N: from a light trailer to twice an axle of 30 t."""
STRESSES = (1e4, 3e9)
"""Largest stresses of an axle, Pa: with less it is not loaded, and no steel withstands more."""
AC = 0.1
"""Mean over the range of a force, from smallest to largest, below which its static part is missing."""
PULL = 0.05
"""Share of the range by which a force may be negative, by noise: a rail does not pull."""


def check_loads(measurement: Measurement, *, unit_given: bool) -> None:
    """Raise InputError for forces of no wheel and stresses of no axle; warn of signals that look wrong.

    With ``unit_given``, the user has confirmed the unit of forces, and a mean far from any wheel load is warned of.
    """
    for name, values in measurement.signals.items():
        what = f"{measurement.source}: {name}"
        if np.ptp(values) == 0.0:
            warn(
                f"{what} is constant at {_shown(name, values[0])} in {len(values)} samples, which no rolling wheel "
                "causes: check the channel"
            )
        if name in WHEELS:
            _check_force(what, values, unit_given=unit_given)
        else:
            _check_stress(what, values)


def _check_force(what: str, values: Real, *, unit_given: bool) -> None:
    low, mean, high = float(values.min()), float(values.mean()), float(values.max())
    size = high - low
    shown = f"{what} is {_force(mean)} on average, from {_force(low)} to {_force(high)}"
    if abs(mean) < AC * size and low < -PULL * size:
        raise InputError(
            f"{shown}: its static load is missing, as behind an AC-coupled amplifier: give --offset with the static "
            "load, such as --offset 98.1kN"
        )
    if mean <= 0.0:
        turned = "tension is positive in it: give --sign tension" if mean < 0.0 else "the channel is dead: leave it out"
        raise InputError(f"{shown}, and a contact force is positive in compression: it looks as if {turned}")
    if low < -PULL * size:
        warn(f"{shown}, and a rail does not pull a wheel down: check the zero, or give --offset")
    if LOADS[0] <= mean <= LOADS[1]:
        return
    words = f"{shown}, and wheels carry {LOADS[0] / 1e3:g} to {LOADS[1] / 1e3:g} kN"
    if unit_given:
        warn(f"{words}: check the unit that you gave by --unit")
        return
    units = [unit for unit, size in (("N", 1e-3), ("kN", 1e3)) if LOADS[0] <= size * mean <= LOADS[1]]
    hint = f"it looks as if the file were in {units[0]}: give --unit {units[0]}" if units else "give its unit, --unit"
    raise InputError(f"{words}: {hint}")


def _check_stress(what: str, values: Real) -> None:
    largest = float(np.abs(values).max())
    if largest > STRESSES[1]:
        raise InputError(
            f"{what} is up to {largest / 1e6:g} MPa, more than steel withstands: give the unit of the file with --unit"
        )
    if 0.0 < largest < STRESSES[0]:
        warn(f"{what} is up to {largest:g} Pa, and axle stresses are some MPa: give the unit of the file with --unit")


def _shown(name: str, value: float) -> str:
    return _force(value) if name in WHEELS else f"{value / 1e6:.4g} MPa"


def _force(value: float) -> str:
    return f"{value / 1e3:.5g} kN"
