"""From the reduced models to the ``causal`` dynamics: coefficients of a step, states at rest, changes of speed.

A mode obeys ``q' = lambda q + g(t)`` with the modal load ``g`` taken linear between samples (first-order hold)::

    q[n+1] = a q[n] + b0 g[n] + b1 g[n+1]

The part that is known before the force of the step is ``r[n+1] = a q[n] + b0 g[n]``, so that ``q = r + b1 g`` and
``r[n+1] = a r[n] + (a b1 + b0) g[n]``; what ``b1 g`` displaces at once is a compliance at lag zero. The compliance at
lag zero from one wheel to the other is left out: no wave crosses axle or sleeper within a step.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..structures.reduced_wheelset import ReducedWheelset
from ..structures.track_ring import TrackRing
from .causal_kernels import Causal
from .hold import hold_coefficients
from .stress_rows import stress_rows

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
    wheel_residual: Real  # (2,) m/N of the wheels
    symmetric: int
    stress_output: Complex  # (S, P)
    stress_feedthrough: Real  # (S, 2)
    stress_rows: NDArray[np.intp]  # (S,) where the components stand in the flattened (nodes, 6)
    changes_speed: ClassVar[bool] = True
    longest_run: ClassVar[float] = math.inf

    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        wheelset = self.wheelset
        wheels = -(wheelset.outputs * (wheelset.inputs.sum(axis=1) / wheelset.poles)).real.sum(axis=1)
        even = slice(0, self.symmetric)
        rail = -(self.track_output[:, even] * self.track_input[:, even] / self.track_poles[even]).real.sum(axis=1)
        displacement: Real = (wheels + self.wheel_residual + (rail + self.track_residual[:, 0]).mean()) * wheel_load
        return displacement

    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Causal:
        """Dynamics at ``speed`` m/s and in equilibrium with ``wheel_load`` N standing on both wheels at ``step``."""
        poles, dt = self.wheelset.poles, dx / speed
        load = self.wheelset.inputs.sum(axis=1) * wheel_load
        wheel = -load / poles - hold_coefficients(poles, dt)[1] * load
        load = self.track_input[step % len(self.track_input)] * wheel_load
        load[self.symmetric :] = 0
        moving = self.track_poles + 1j * self.track_wavenumbers * speed
        track = -load / self.track_poles - hold_coefficients(moving, dt)[1] * load
        return self._at(_parts(wheel), _parts(track), dx, speed, speed)

    def at_speed(self, dynamics: Causal, dx: float, speed: float, behind: float) -> Causal:
        """Dynamics at another ``speed`` m/s, with the state of ``dynamics``, which is stepped in place.

        For the one step at which the speed changes, ``behind`` is the speed with which that step was reached: what
        its own force displaces belongs to the interval behind it, everything else to the one ahead.
        """
        return self._at(dynamics.wheel_state, dynamics.track_state, dx, speed, behind)

    def _at(self, wheel_state: Real, track_state: Real, dx: float, speed: float, behind: float) -> Causal:
        poles = self.wheelset.poles
        a, c, b1 = _coefficients(poles, poles, dx, speed, behind)
        outputs, inputs = self.wheelset.outputs, self.wheelset.inputs
        wheel_compliance = (outputs * b1 * inputs.T).real.sum(axis=1) + self.wheel_residual
        stress_direct = (self.stress_output @ (b1[:, np.newaxis] * inputs)).real + self.stress_feedthrough
        ahead = self.track_poles + 1j * self.track_wavenumbers * speed
        back = self.track_poles + 1j * self.track_wavenumbers * behind
        track_a, track_c, track_b1 = _coefficients(ahead, back, dx, speed, behind)
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


def causal_model(wheelset: ReducedWheelset, track: TrackRing, nodes: Sequence[str], lag_zero: str) -> CausalModel:
    """Join the reduced models; raises InputError for a stress node that the wheelset does not have.

    ``lag_zero`` is a variant of ``scenario.LAG_ZERO``: which residuals displace the contacts at the force's instant.
    """
    rows, kept = stress_rows(wheelset, nodes)
    modes = len(wheelset.poles)
    halves = (track.symmetric, track.antisymmetric)
    residual = np.stack([half.residual for half in halves], axis=1)
    own = np.diag(wheelset.displacement_residual)
    return CausalModel(
        wheelset=wheelset,
        track_poles=np.concatenate([half.poles for half in halves]),
        track_wavenumbers=np.concatenate([half.wavenumbers for half in halves]),
        track_input=np.concatenate([half.input for half in halves], axis=1),
        track_output=np.concatenate([half.output for half in halves], axis=1),
        track_residual=np.zeros_like(residual) if lag_zero == "zero" else residual,
        wheel_residual=own if lag_zero == "wheel_residual" else np.zeros_like(own),
        symmetric=len(track.symmetric.poles),
        stress_output=wheelset.stress_outputs[rows].reshape(-1, modes)[kept],
        stress_feedthrough=wheelset.stress_feedthrough[rows].reshape(-1, 2)[kept],
        stress_rows=kept,
    )


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
        stress_feedthrough=wheelset.stress_feedthrough - (wheelset.stress_outputs[..., ~kept] @ left_out).real,
        displacement_residual=wheelset.displacement_residual - (wheelset.outputs[:, ~kept] @ left_out).real,
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
