"""What messages of a bag may say: checked before anything is made of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..samples.decimation import FACTOR
from ..scenario import WHEELS
from ..wheelset.reduced import COMPONENTS
from .messages import State, block_of, state_of

LATEST = 9e9
"""Largest simulated time, s: 2^63 ns."""
LAST = 2**64 - 2**32
"""Largest step."""
BEYOND = 1e30
"""Forces, N, and stresses, Pa, of no run; their squares are still numbers."""
STEP = (1e-6, 1.0)
"""Smallest and largest step along the track, m."""


class ContentError(ValueError):
    """A message says what no run can have."""


def checked_span(message: Any, signals: Sequence[str]) -> int:
    """Number of samples of a message; ContentError if its arrays differ in length, or time or speed are none."""
    lengths = {name: len(getattr(message, name)) for name in signals}
    if len({*lengths.values()}) > 1:
        raise ContentError(f"its arrays differ in length, {', '.join(f'{n} {name}' for name, n in lengths.items())}")
    check_place(message)
    (samples,) = {*lengths.values()}
    if not samples:
        raise ContentError("it holds no samples")
    return samples


def check_place(message: Any) -> None:
    """Raise ContentError if step, time, position or speed of a message are not those of a run."""
    for name in ("time", "position", "speed", "step_period"):
        if not math.isfinite(getattr(message, name)):
            raise ContentError(f"{name} at step {message.first_step} is {getattr(message, name)}")
    if not 0 <= message.first_step <= LAST or abs(message.time) > LATEST:
        raise ContentError(f"step {message.first_step} at {message.time:g} s is after {LAST} or {LATEST:g} s")
    factor = getattr(message, "decimation", 1)
    if not 1 <= factor <= FACTOR.high:
        raise ContentError(f"it has only every {factor}th sample")
    if not (message.speed > 0 and STEP[0] <= message.speed * message.step_period / factor <= STEP[1]):
        raise ContentError(
            f"speed {message.speed:g} m/s and step period {message.step_period:g} s at step {message.first_step} are "
            f"not those of a run with steps from {STEP[0]:g} to {STEP[1]:g} m"
        )


def span_of(message: Any) -> int:
    """Number of samples of a ContactForces or AxleStress."""
    return checked_span(message, COMPONENTS if hasattr(message, "node") else WHEELS)


def check_finite(message: Any) -> None:
    """Raise ContentError for a ContactForces or AxleStress with a sample that is not finite."""
    for name in COMPONENTS if hasattr(message, "node") else WHEELS:
        values = getattr(message, name)
        if not _held(values):
            raise ContentError(f"{name} from step {message.first_step} on has {values[~(abs(values) < BEYOND)][0]}")


def _held(values: Real) -> bool:
    """Whether all values are numbers that a run can have."""
    return bool(not values.size or (values.min() > -BEYOND and values.max() < BEYOND))


def checked_block(forces: Any, stresses: Sequence[Any]) -> SampleBlock:
    """Block of a ContactForces and the AxleStress of each node; ContentError names what no run can have."""
    samples = checked_span(forces, WHEELS)
    for stress in stresses:
        if checked_span(stress, COMPONENTS) != samples:
            raise ContentError(
                f"node {stress.node} has {len(stress.xx)} samples, and the contact forces have {samples}"
            )
    block = block_of(forces, [*stresses])
    names = [f"contact force {wheel}" for wheel in WHEELS]
    names += [f"stress {node} {component}" for node in block.nodes for component in COMPONENTS]
    for begun, values in ((0, block.forces), (len(WHEELS), block.stresses.reshape(samples, -1))):
        if not _held(values):
            row, column = np.argwhere(~(abs(values) < BEYOND))[0]
            raise ContentError(
                f"{names[begun + column]} at step {block.first_step + int(row)} is {values[row, column]}"
            )
    return block


def checked_wheel(number: int) -> int:
    """Index of a wheel; ContentError for one that is not there."""
    if not 1 <= number <= len(WHEELS):
        raise ContentError(f"wheel {number} is neither 1 nor 2")
    return number - 1


def checked_state(message: Any) -> State:
    """State of a SimulationState; ContentError names what no run can have."""
    check_place(message)
    for name in ("speed_set_point", "axle_load"):
        if not math.isfinite(getattr(message, name)):
            raise ContentError(f"{name} at step {message.first_step} is {getattr(message, name)}")
    return state_of(message)
