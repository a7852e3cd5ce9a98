"""Loads and stresses of a run of samples in scalars."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..stress.principal import maximum_principal
from .block import SampleBlock


@dataclass(frozen=True)
class WheelLoad:
    """Contact force of one wheel."""

    max_force: float
    """N"""
    min_force: float
    """N"""
    mean_force: float
    """N"""
    rms_force: float
    """Root of the mean square, N."""
    contact_loss: float
    """Time without contact, s."""


@dataclass(frozen=True)
class NodeStress:
    """Maximum principal stress at one node."""

    name: str
    max_principal: float
    """Largest value over time, Pa."""
    min_principal: float
    """Smallest value over time, Pa."""


@dataclass(frozen=True)
class Summary:
    """Both wheels and all stress nodes over a run of samples."""

    samples: int
    wheels: tuple[WheelLoad, WheelLoad]
    nodes: tuple[NodeStress, ...]


def summarise(block: SampleBlock, principal: NDArray[np.float64] | None = None) -> Summary:
    """Summary of a block; ``principal`` (samples, nodes) Pa is its maximum principal stress if that is known already.

    Raises ValueError for a block without samples.
    """
    if principal is None:
        principal = maximum_principal(block.stresses)
    wheel_1, wheel_2 = (
        WheelLoad(
            max_force=float(force.max()),
            min_force=float(force.min()),
            mean_force=float(force.mean()),
            rms_force=math.sqrt(float(force @ force) / len(force)),
            contact_loss=int(np.count_nonzero(force <= 0)) * block.step_period,
        )
        for force in block.forces.T
    )
    nodes = tuple(
        NodeStress(name, float(stress.max()), float(stress.min()))
        for name, stress in zip(block.nodes, principal.T, strict=True)
    )
    return Summary(len(block), (wheel_1, wheel_2), nodes)


def combine(parts: Iterable[Summary]) -> Summary:
    """Summary of consecutive runs of samples as one; raises ValueError if there is none."""
    parts = list(parts)
    if not parts:
        raise ValueError("there is nothing to combine")
    samples = sum(part.samples for part in parts)
    weights = [part.samples / samples for part in parts]
    wheel_1, wheel_2 = (
        WheelLoad(
            max_force=max(load.max_force for load in loads),
            min_force=min(load.min_force for load in loads),
            mean_force=sum(weight * load.mean_force for weight, load in zip(weights, loads, strict=True)),
            rms_force=math.sqrt(sum(weight * load.rms_force**2 for weight, load in zip(weights, loads, strict=True))),
            contact_loss=sum(load.contact_loss for load in loads),
        )
        for loads in zip(*(part.wheels for part in parts), strict=True)
    )
    nodes = tuple(
        NodeStress(
            stresses[0].name,
            max(stress.max_principal for stress in stresses),
            min(stress.min_principal for stress in stresses),
        )
        for stresses in zip(*(part.nodes for part in parts), strict=True)
    )
    return Summary(samples, (wheel_1, wheel_2), nodes)
