"""Bending amplitudes of a run: those of the turn with the largest, at each stress node."""

from __future__ import annotations

import math

import numpy as np

from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..samples.rotating_bending import RotatingBending
from ..scenario import Scenario
from ..wheelset.reduced import COMPONENTS

AXIAL = COMPONENTS.index("yy")
"""Stress along the axle, which bends: its component."""


class BendingAmplitudes:
    """Amplitudes of the bending stress that points of the turning axle go through, from blocks without their mean.

    Without models, the given constant stresses of the scenario are the mean. Press fits need the models for that, so
    that amplitudes are unknown with them.
    """

    def __init__(self, means: Real, turn: int, *, known: bool = True) -> None:
        """For wheels of ``turn`` steps and the constant axial stress at each node, (nodes,), Pa."""
        self._means, self._known, self._turn = means, known, turn
        self._largest = np.zeros(len(means))
        self.leave()

    @classmethod
    def of(cls, scenario: Scenario, turn: int, nodes: tuple[str, ...]) -> BendingAmplitudes:
        """Without models."""
        loads = scenario.loads
        given = [(nodes.index(item.node), item.yy) for item in loads.stresses if item.node in nodes]
        means = np.bincount([node for node, _ in given], [mean for _, mean in given], len(nodes))
        return cls(means.astype(np.float64), turn, known=not (loads.press_fit.wheels or loads.press_fit.equipment))

    def leave(self) -> None:
        """Begin a new stretch: steps are missing."""
        self._bending = RotatingBending(self._turn, len(self._means))

    def push(self, block: SampleBlock) -> None:
        """Take in the next steps."""
        turns = self._bending.push(block.first_step, block.stresses[:, :, AXIAL] - self._means)
        for amplitudes in (*turns, self._bending.amplitudes.begun):
            self._largest = np.fmax(self._largest, amplitudes)

    @property
    def largest(self) -> tuple[float, ...]:
        """The largest so far, Pa, by node; NaN if unknown."""
        return tuple(self._largest.tolist() if self._known else [math.nan] * len(self._means))
