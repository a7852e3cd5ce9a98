"""Loads and stresses of a run of samples in scalars."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import Real
from .block import NO_CONTACTS, ContactCounts, SampleBlock


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
    mean_principal: float
    """Mean over time, Pa."""
    rms_principal: float
    """Root of the mean square over time, Pa."""


class Statistics(NamedTuple):
    """What a signal comes to over a run of samples, in its own unit."""

    max: Real
    min: Real
    mean: Real
    rms: Real
    """Root of the mean square."""


@dataclass(frozen=True)
class Summary:
    """Both wheels and all stress nodes over a run of samples."""

    samples: int
    wheels: tuple[WheelLoad, WheelLoad]
    nodes: tuple[NodeStress, ...]
    contacts: ContactCounts = NO_CONTACTS
    """How the contacts of a simulation were found."""


def statistics(signals: Real) -> Statistics:
    """Statistics (signals,) of signals (signals, samples), contiguous; ValueError if there are no samples."""
    squares = np.einsum("ij,ij->i", signals, signals)
    return Statistics(
        signals.max(axis=1), signals.min(axis=1), signals.mean(axis=1), np.sqrt(squares / signals.shape[1])
    )


def summarise(block: SampleBlock) -> Summary:
    """Summary of a block; raises ValueError for one without samples."""
    forces = np.ascontiguousarray(block.forces.T)
    lost = np.count_nonzero(forces <= 0, axis=1) * block.step_period
    wheel_1, wheel_2 = (WheelLoad(*map(float, found)) for found in zip(*statistics(forces), lost, strict=True))
    nodes = tuple(
        NodeStress(name, *map(float, found))
        for name, *found in zip(block.nodes, *statistics(np.ascontiguousarray(block.max_principal.T)), strict=True)
    )
    return Summary(len(block), (wheel_1, wheel_2), nodes, block.contacts)


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
            mean_force=_mean(weights, (load.mean_force for load in loads)),
            rms_force=math.sqrt(_mean(weights, (load.rms_force**2 for load in loads))),
            contact_loss=sum(load.contact_loss for load in loads),
        )
        for loads in zip(*(part.wheels for part in parts), strict=True)
    )
    nodes = tuple(
        NodeStress(
            stresses[0].name,
            max(stress.max_principal for stress in stresses),
            min(stress.min_principal for stress in stresses),
            _mean(weights, (stress.mean_principal for stress in stresses)),
            math.sqrt(_mean(weights, (stress.rms_principal**2 for stress in stresses))),
        )
        for stresses in zip(*(part.nodes for part in parts), strict=True)
    )
    contacts = sum((part.contacts for part in parts), NO_CONTACTS)
    return Summary(samples, (wheel_1, wheel_2), nodes, contacts)


def _mean(weights: Iterable[float], values: Iterable[float]) -> float:
    return sum(weight * value for weight, value in zip(weights, values, strict=True))
