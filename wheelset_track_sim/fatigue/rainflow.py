"""Streams of stress, counted as rainflow cycles with their damage: the same bits however the streams are cut."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..runtime.arrays import Real
from . import rainflow_kernels as kernels
from .curve import Curve
from .rainflow_kernels import Channels

GATE = 0.05e6
"""Ranges up to this are merged by default, Pa."""


@dataclass(frozen=True, eq=False)
class StressSpectrum:
    """What C channels have gone through, residue included. Spectra of several runs add up."""

    half_cycles: NDArray[np.int64]
    """(C, ranges, means): see ``ranges`` and ``means``."""
    sums: Real
    """(C, ranges, 2): sums of range and of mean over the half cycles of a row of the matrix, Pa."""
    crossings: NDArray[np.int64]
    """(C, levels) upward crossings of ``levels``, of turning points beyond the gate."""
    damage: Real
    """(C, rules), 1."""
    merged: NDArray[np.int64]
    """(C,) cycles within the gate, which are not counted."""
    forced: NDArray[np.int64]
    """(C,) half cycles that were counted early because the memory for the residue was full."""
    merged_at_most: Real
    """(C, rules): damage of the merged cycles if each had the range of the gate, at mean stress 0."""

    def __add__(self, other: StressSpectrum) -> StressSpectrum:
        return StressSpectrum(**{key.name: getattr(self, key.name) + getattr(other, key.name) for key in fields(self)})

    def channel(self, number: int) -> StressSpectrum:
        """Spectrum of one channel, with C = 1."""
        return StressSpectrum(**{key.name: getattr(self, key.name)[number : number + 1] for key in fields(self)})

    @property
    def cycles(self) -> Real:
        """(C,) cycles; those of the residue count half."""
        cycles: Real = self.half_cycles.sum(axis=(1, 2)) / 2
        return cycles

    def cells(self, channel: int) -> tuple[Real, Real, Real]:
        """Cycles of a channel by cell of its matrix, those that hold any: range, Pa, mean, Pa, and number, each (n,).

        The range is the mean range of the row, and means are the middles of cells, shifted together so that their mean
        over the row is that of its cycles. So a cell of 5 MPa by 10 MPa does not round constant amplitudes.
        """
        row, column = np.nonzero(self.half_cycles[channel])
        halves = self.half_cycles[channel, row, column].astype(np.float64)
        of_row = self.half_cycles[channel].sum(axis=1)[row]
        span, mean = (self.sums[channel, row] / of_row[:, np.newaxis]).T
        middle = self.means[column] + kernels.MEAN_WIDTH / 2
        shift = mean - np.bincount(row, halves * middle, minlength=kernels.RANGES)[row] / of_row
        return span, middle + shift, halves / 2

    @property
    def ranges(self) -> Real:
        """Lower borders of the rows of the matrix, Pa."""
        return kernels.RANGE_WIDTH * np.arange(kernels.RANGES, dtype=np.float64)

    @property
    def means(self) -> Real:
        """Lower borders of the columns of the matrix, Pa."""
        return kernels.MEAN_WIDTH * (np.arange(kernels.MEANS, dtype=np.float64) - kernels.MEANS // 2)

    @property
    def levels(self) -> Real:
        """Pa."""
        return kernels.LEVEL_WIDTH * (np.arange(kernels.LEVELS, dtype=np.float64) - kernels.LEVELS // 2)


class Rainflow:
    """Counts cycles of C channels as they come, with bounded memory.

    Examples
    --------
    >>> count = Rainflow(1, load_curve("assumed_body"), gate=0.0)
    >>> count.push(np.array([[-2.0, 1, -3, 5, -1, 3, -4, 4, -2]]) * 25e6)  # ASTM E1049-85, Fig. 6
    >>> float(count.spectrum.cycles[0])
    4.0
    """

    def __init__(self, channels: int, curve: Curve, gate: float = GATE) -> None:
        """Count a number of channels; ranges up to the gate, Pa, are merged."""
        if not 0.0 <= gate <= kernels.RANGE_WIDTH:
            raise InputError(f"gate = {gate:g} Pa is out of range: give 0 to {kernels.RANGE_WIDTH:g} Pa")
        self.curve, self.gate = curve, gate
        self.sensitivity = curve.mean_stress_sensitivity
        self.state = Channels(
            stresses=np.zeros((channels, kernels.STRESSES)),
            counts=np.zeros((channels, kernels.COUNTS), dtype=np.int64),
            residue=np.zeros((channels, kernels.CAPACITY)),
            matrix=np.zeros((channels, kernels.RANGES, kernels.MEANS), dtype=np.int64),
            sums=np.zeros((channels, kernels.RANGES, 2)),
            crossings=np.zeros((channels, kernels.LEVELS + 1), dtype=np.int64),
            damage=np.zeros((channels, len(curve.rules))),
        )

    def push(self, stress: Real) -> None:
        """Count further samples (C, n), Pa."""
        for channel, samples in enumerate(np.ascontiguousarray(stress, dtype=np.float64)):
            kernels.count(self.state, channel, samples, self.gate, self.sensitivity, self.curve.constants)

    @property
    def spectrum(self) -> StressSpectrum:
        """All cycles so far; the residue counts as half cycles, and the count can go on."""
        state = copy.deepcopy(self.state)
        turning = state.counts[:, kernels.TURNING].copy()
        kernels.finish(state, self.sensitivity, self.curve.constants)
        # The first turning point and the last extreme are ends of the signal, not reversals.
        inner = np.maximum(turning - 1, 0)
        merged = np.maximum(state.counts[:, kernels.REVERSALS] - inner, 0) // 2
        each = np.array([kernels.damage_of(self.gate / 2, rule) for rule in self.curve.constants])
        return StressSpectrum(
            half_cycles=state.matrix,
            sums=state.sums,
            crossings=np.cumsum(state.crossings[:, :-1], axis=1),
            damage=state.damage,
            merged=merged,
            forced=state.counts[:, kernels.FORCED],
            merged_at_most=merged[:, np.newaxis] * each,
        )

    @property
    def damage(self) -> Real:
        """Damage so far, (C, rules): that of ``spectrum``, at less cost."""
        found: Real = kernels.damage_so_far(self.state, self.sensitivity, self.curve.constants)
        return found

    def saved(self) -> dict[str, NDArray[Any]]:
        """Arrays from which ``resume`` goes on, as ``numpy.savez`` takes them."""
        return {name: array.copy() for name, array in self.state._asdict().items()}

    def resume(self, saved: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a saved state of the same channels, curve and gate; raises InputError if shapes differ."""
        for name, array in self.state._asdict().items():
            if name not in saved or saved[name].shape != array.shape or saved[name].dtype != array.dtype:
                raise InputError(f"the saved count has no {name} of shape {array.shape}: give one of the same channels")
        self.state = Channels(**{name: np.array(saved[name]) for name in self.state._fields})
