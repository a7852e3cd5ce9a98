"""From the reduced models to the ``causal`` dynamics: coefficients of a step, states at rest, changes of speed.

A mode obeys ``q' = lambda q + g(t)`` with the modal load ``g`` taken linear between samples (first-order hold)::

    q[n+1] = a q[n] + b0 g[n] + b1 g[n+1]

The part that is known before the force of the step is ``r[n+1] = a q[n] + b0 g[n]``, so that ``q = r + b1 g`` and
``r[n+1] = a r[n] + (a b1 + b0) g[n]``; what ``b1 g`` displaces at once is a compliance at lag zero. The compliance at
lag zero from one wheel to the other is left out: no wave crosses axle or sleeper within a step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..schema import unknown
from ..structures.reduced_wheelset import ReducedWheelset
from ..structures.track_ring import TrackRing
from .causal_kernels import Causal
from .hold import hold_coefficients

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CausalModel:
    """Reduced models of one wheelset and one track, ready to be stepped at any speed.

    P wheelset modes, Q track modes (the symmetric half's first), L steps a bay, S stress components.
    """

    wheelset: ReducedWheelset
    track_poles: Complex
    track_wavenumbers: Real
    track_input: Complex  # (L, Q)
    track_output: Complex  # (L, Q)
    track_residual: Real  # (L, 2) m/N of the symmetric and the antisymmetric half
    symmetric: int
    stress_output: Complex  # (S, P)
    stress_feedthrough: Real  # (S, 2)
    stress_rows: NDArray[np.intp]  # (S,) where the components stand in the flattened (nodes, 6)

    def preload(self, wheel_load: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        wheelset = self.wheelset
        wheels = -(wheelset.outputs * (wheelset.inputs.sum(axis=1) / wheelset.poles)).real.sum(axis=1)
        even = slice(0, self.symmetric)
        rail = -(self.track_output[:, even] * self.track_input[:, even] / self.track_poles[even]).real.sum(axis=1)
        displacement: Real = (wheels + (rail + self.track_residual[:, 0]).mean()) * wheel_load
        return displacement

    def at_rest(self, wheel_load: float, step: int, dt: float, speed: float) -> tuple[Real, Real]:
        """States (2, P) and (2, Q) of wheelset and track under ``wheel_load`` N standing on both wheels at ``step``."""
        poles = self.wheelset.poles
        load = self.wheelset.inputs.sum(axis=1) * wheel_load
        wheel = -load / poles - hold_coefficients(poles, dt)[1] * load
        load = self.track_input[step % len(self.track_input)] * wheel_load
        load[self.symmetric :] = 0
        moving = self.track_poles + 1j * self.track_wavenumbers * speed
        track = -load / self.track_poles - hold_coefficients(moving, dt)[1] * load
        return _parts(wheel), _parts(track)

    def dynamics(self, dx: float, speed: float, wheel_state: Real, track_state: Real, behind: float = 0.0) -> Causal:
        """Dynamics at ``speed`` m/s with steps of ``dx`` m from given states, which are stepped in place.

        For the one step at which the speed changes, ``behind`` is the speed with which that step was reached: what
        its own force displaces belongs to the interval behind it, everything else to the one ahead.
        """
        poles = self.wheelset.poles
        a, c, b1 = _coefficients(poles, poles, dx, speed, behind or speed)
        outputs, inputs = self.wheelset.outputs, self.wheelset.inputs
        wheel_compliance = (outputs * b1 * inputs.T).real.sum(axis=1)
        stress_direct = (self.stress_output @ (b1[:, np.newaxis] * inputs)).real + self.stress_feedthrough
        ahead = self.track_poles + 1j * self.track_wavenumbers * speed
        back = self.track_poles + 1j * self.track_wavenumbers * (behind or speed)
        track_a, track_c, track_b1 = _coefficients(ahead, back, dx, speed, behind or speed)
        at_once = (self.track_output * track_b1 * self.track_input).real
        halves = np.stack([at_once[:, : self.symmetric].sum(axis=1), at_once[:, self.symmetric :].sum(axis=1)], axis=1)
        rail_compliance = (halves + self.track_residual).mean(axis=1)
        return Causal(
            wheel_state=wheel_state,
            wheel_factor=_parts(a),
            wheel_gain=_parts((c[:, np.newaxis] * inputs).T),
            wheel_output=_parts(outputs),
            track_state=track_state,
            track_factor=_parts(track_a),
            track_gain=_parts(track_c),
            track_input=_parts(self.track_input),
            track_output=_parts(self.track_output),
            symmetric=self.symmetric,
            stress_output=_parts(self.stress_output),
            stress_direct=stress_direct,
            compliance=np.ascontiguousarray(rail_compliance[:, np.newaxis] + wheel_compliance),
        )


def causal_model(wheelset: ReducedWheelset, track: TrackRing, nodes: Sequence[str]) -> CausalModel:
    """Join the reduced models; raises InputError for a stress node that the wheelset does not have."""
    for index, node in enumerate(nodes):
        if node not in wheelset.node_names:
            where = f"output.stress_nodes.{index} = {node!r}"
            raise InputError(unknown("stress node of this wheelset", where, node, wheelset.node_names))
    rows = [wheelset.node_names.index(node) for node in nodes]
    modes = len(wheelset.poles)
    stress = wheelset.stress_outputs[rows].reshape(-1, modes)
    feedthrough = wheelset.stress_feedthrough[rows].reshape(-1, 2)
    size = np.abs(stress).max(axis=1, initial=0.0) * np.abs(wheelset.inputs).max() + np.abs(feedthrough).max(
        axis=1, initial=0.0
    )
    kept = np.flatnonzero(size > 1e-9 * size.max(initial=0.0))  # the others are zero by symmetry
    halves = (track.symmetric, track.antisymmetric)
    return CausalModel(
        wheelset=wheelset,
        track_poles=np.concatenate([half.poles for half in halves]),
        track_wavenumbers=np.concatenate([half.wavenumbers for half in halves]),
        track_input=np.concatenate([half.input for half in halves], axis=1),
        track_output=np.concatenate([half.output for half in halves], axis=1),
        track_residual=np.stack([half.residual for half in halves], axis=1),
        symmetric=len(track.symmetric.poles),
        stress_output=stress[kept],
        stress_feedthrough=feedthrough[kept],
        stress_rows=kept,
    )


def _coefficients(
    ahead: Complex, behind: Complex, dx: float, v_ahead: float, v_behind: float
) -> tuple[Complex, Complex, Complex]:
    """Factor a, gain c = a b1 + b0 and lag-zero coefficient b1; b1 of the interval behind the step."""
    dt = dx / v_ahead
    a = np.exp(ahead * dt)
    b1 = hold_coefficients(behind, dx / v_behind)[1]
    return a, a * b1 + hold_coefficients(ahead, dt)[0], b1


def _parts(values: Complex) -> Real:
    """Real and imaginary parts stacked in front, contiguous."""
    return np.ascontiguousarray(np.stack([values.real, values.imag]))
