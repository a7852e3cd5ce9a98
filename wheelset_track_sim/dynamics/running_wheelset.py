"""The wheelset's part of the streaming dynamics: coefficients of a step, the state at rest, stress.

``causal`` explains the step of a mode. The compliance at lag zero from one wheel to the other is left out: no wave
crosses the axle within a step.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..inputs.schema import unknown
from ..runtime.arrays import Complex, Real
from ..wheelset.reduced import ReducedWheelset
from .banks import REGISTER, banked, padded, unbanked, whole_registers
from .hold import hold

STATIC_STRESS = 5e-4
"""Share of the largest static stress that modes may hold together to answer at once instead of being summed up."""


class Wheels(NamedTuple):
    """State and coefficients of the wheelset, as fields of that name in ``causal_kernels.Causal``."""

    wheels: Real
    wheel_modes: int
    stress_output: Real
    stress_modes: int
    stress_direct: Real
    sensor_output: Real
    sensor_modes: int
    sensor_direct: Real
    wheel_compliance: Real


@dataclass(frozen=True, eq=False)
class RunningWheelset:
    """Reduced wheelset, ready to be stepped at any speed: P modes, S stress components."""

    wheelset: ReducedWheelset
    wheel_residual: Real  # (2,) m/N of the wheels
    stress_output: Complex  # (S, R) of the first R modes; the others answer at once
    stress_feedthrough: Real  # (S, 2)
    stress_rows: NDArray[np.intp]  # (S,) where the components stand in the flattened (nodes, 6)
    longest_run: ClassVar[float] = math.inf

    @property
    def sensor_rows(self) -> int:
        """Rows of sensors that are stepped."""
        return len(self.wheelset.sensor_outputs)

    def static_wheels(self) -> Real:
        """Displacement (2,) m/N of the wheels under unit loads on both of them."""
        displacement: Real = self.wheelset.static_receptance().sum(axis=1) + self.wheel_residual
        return displacement

    def standing(self, wheel_load: float, dt: float) -> Complex:
        """State (P,) in equilibrium with ``wheel_load`` N on both wheels, but for the force of the coming step."""
        poles, load = self.wheelset.poles, self.wheelset.inputs.sum(axis=1) * wheel_load
        state: Complex = -load / poles - hold(poles, dt).after * load
        return state

    def state_of(self, wheels: Real) -> Complex:
        """State (P,) that ``wheels`` of ``Wheels`` hold."""
        return unbanked(wheels, len(self.wheelset.poles))

    def at(self, state: Complex, dx: float, speed: float, behind: float) -> Wheels:
        """Coefficients with a ``state`` (P,) at ``speed`` m/s; ``behind`` is that of the last interval."""
        poles, inputs, outputs = self.wheelset.poles, self.wheelset.inputs, self.wheelset.outputs
        (a, b0, _), b1 = hold(poles, dx / speed), hold(poles, dx / behind).after
        sensors, pairs = self.wheelset.sensor_outputs, -(-self.sensor_rows // 2)
        sensing = int(np.flatnonzero(np.append(True, np.abs(sensors).max(axis=0, initial=0.0)))[-1])  # modes
        summed, groups = self.stress_output.shape[1], -(-len(self.stress_output) // 4)
        stress_direct = (self.stress_output @ (b1[:summed, np.newaxis] * inputs[:summed])).real
        gains = ((a * b1 + b0)[:, np.newaxis] * inputs).T
        return Wheels(
            wheels=banked(np.stack([state, a, *gains, *outputs])),
            wheel_modes=whole_registers(len(poles)),
            stress_output=banked(padded(self.stress_output, 0, 4 * groups).reshape(groups, 4, summed)),
            stress_modes=whole_registers(summed),
            stress_direct=stress_direct + self.stress_feedthrough,
            sensor_output=banked(padded(sensors, 0, 2 * pairs)[:, :sensing].reshape(pairs, 2, sensing)),
            sensor_modes=whole_registers(sensing),
            sensor_direct=(sensors @ (b1[:, np.newaxis] * inputs)).real + self.wheelset.sensor_feedthrough,
            wheel_compliance=(outputs * b1 * inputs.T).real.sum(axis=1) + self.wheel_residual,
        )


def running_wheelset(wheelset: ReducedWheelset, nodes: Sequence[str], lag_zero: str) -> RunningWheelset:
    """Wheelset with the stress of ``nodes``; raises InputError for one that it does not have.

    ``lag_zero`` is a variant of ``scenario.LAG_ZERO``: which residuals displace the contacts at the force's instant.
    """
    nodes_at, kept = stress_rows(wheelset, nodes)
    wheelset, summed = _by_static_stress(wheelset, nodes_at)
    stress_outputs = wheelset.stress_outputs[nodes_at].reshape(-1, len(wheelset.poles))[kept]
    at_once = -(stress_outputs[:, summed:] @ (wheelset.inputs[summed:] / wheelset.poles[summed:, np.newaxis])).real
    own = np.diag(wheelset.displacement_residual)
    return RunningWheelset(
        wheelset=wheelset,
        wheel_residual=own if lag_zero == "wheel_residual" else np.zeros_like(own),
        stress_output=stress_outputs[:, :summed],
        stress_feedthrough=wheelset.stress_feedthrough[nodes_at].reshape(-1, 2)[kept] + at_once,
        stress_rows=kept,
    )


def _by_static_stress(wheelset: ReducedWheelset, nodes: Sequence[int]) -> tuple[ReducedWheelset, int]:
    """Modes in the order of what they add to the static stress of ``nodes``, and how many of them are summed up."""
    modal = (
        wheelset.stress_outputs[nodes].reshape(-1, len(wheelset.poles), 1)
        * wheelset.inputs
        / wheelset.poles[:, np.newaxis]
    )
    share = np.abs(modal).max(axis=(0, 2), initial=0.0)
    order = np.argsort(-share, kind="stable")
    static = np.abs(modal.real.sum(axis=1)).max(initial=0.0)
    left = np.cumsum(share[order][::-1])[::-1]  # of each mode and all behind it
    summed = int((left > STATIC_STRESS * static).sum())
    ordered = dataclasses.replace(
        wheelset,
        poles=wheelset.poles[order],
        inputs=wheelset.inputs[order],
        outputs=wheelset.outputs[:, order],
        stress_outputs=wheelset.stress_outputs[..., order],
        sensor_outputs=wheelset.sensor_outputs[:, order],
    )
    return ordered, min(-(-summed // REGISTER) * REGISTER, len(order))


def truncated(wheelset: ReducedWheelset, max_frequency: float) -> ReducedWheelset:
    """Reduced wheelset without the modes above ``max_frequency`` Hz; what they deflect and stress statically stays."""
    kept = wheelset.frequencies <= max_frequency
    left_out = wheelset.inputs[~kept] / wheelset.poles[~kept, np.newaxis]
    return dataclasses.replace(
        wheelset,
        poles=wheelset.poles[kept],
        inputs=wheelset.inputs[kept],
        outputs=wheelset.outputs[:, kept],
        stress_outputs=wheelset.stress_outputs[..., kept],
        sensor_outputs=wheelset.sensor_outputs[:, kept],
        sensor_feedthrough=wheelset.sensor_feedthrough - (wheelset.sensor_outputs[:, ~kept] @ left_out).real,
        stress_feedthrough=wheelset.stress_feedthrough - (wheelset.stress_outputs[..., ~kept] @ left_out).real,
        displacement_residual=wheelset.displacement_residual - (wheelset.outputs[:, ~kept] @ left_out).real,
    )


def stress_rows(wheelset: ReducedWheelset, nodes: Sequence[str]) -> tuple[list[int], NDArray[np.intp]]:
    """Indices of stress nodes, and which of their components, (nodes, 6) flattened, are not zero by symmetry."""
    for index, node in enumerate(nodes):
        if node not in wheelset.node_names:
            where = f"output.stress_nodes.{index} = {node!r}"
            raise InputError(unknown("stress node of this wheelset", where, node, wheelset.node_names))
    rows = [wheelset.node_names.index(node) for node in nodes]
    shapes = np.abs(wheelset.stress_outputs[rows]).max(axis=-1, initial=0.0) * np.abs(wheelset.inputs).max()
    size = (shapes + np.abs(wheelset.stress_feedthrough[rows]).max(axis=-1, initial=0.0)).ravel()
    return rows, np.flatnonzero(size > 1e-9 * size.max(initial=0.0))
