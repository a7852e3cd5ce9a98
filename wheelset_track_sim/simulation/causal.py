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
from functools import lru_cache
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..structures.reduced_wheelset import ReducedWheelset
from ..structures.track_balance import HalfModes, MovingTrack
from .causal_kernels import Causal
from .hold import hold_coefficients
from .stress_rows import stress_rows

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CausalModel:
    """Reduced models of one wheelset and one track, ready to be stepped at any speed.

    P wheelset modes, L steps a bay, S stress components.
    """

    wheelset: ReducedWheelset
    track: MovingTrack
    wheel_residual: Real  # (2,) m/N of the wheels
    stress_output: Complex  # (S, P)
    stress_feedthrough: Real  # (S, 2)
    stress_rows: NDArray[np.intp]  # (S,) where the components stand in the flattened (nodes, 6)
    changes_speed: ClassVar[bool] = True
    longest_run: ClassVar[float] = math.inf

    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        wheels = self.wheelset.static_receptance().sum(axis=1) + self.wheel_residual
        displacement: Real = (wheels + self.track.symmetric.compliance().mean()) * wheel_load
        return displacement

    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Causal:
        """Dynamics at ``speed`` m/s and in equilibrium with ``wheel_load`` N standing on both wheels at ``step``."""
        poles, dt = self.wheelset.poles, dx / speed
        load = self.wheelset.inputs.sum(axis=1) * wheel_load
        wheel = -load / poles - hold_coefficients(poles, dt)[1] * load
        even, odd = _halves(self, speed)
        place = step % len(even.input)
        state = even.from_state @ self.track.symmetric.standing(place, wheel_load)
        state -= hold_coefficients(even.poles, dt)[1] * even.input[place] * wheel_load
        track = np.concatenate([state, np.zeros(len(odd.poles))])
        return self._at(_parts(wheel), _parts(track), dx, speed, speed)

    def at_speed(self, dynamics: Causal, dx: float, speed: float, behind: float) -> Causal:
        """Dynamics at another ``speed`` m/s, with the state of ``dynamics``.

        For the one step at which the speed changes, ``behind`` is the speed with which that step was reached: what
        its own force displaces belongs to the interval behind it, everything else to the one ahead.
        """
        track = dynamics.track_state
        if dynamics.speed != speed:
            before, after = _halves(self, dynamics.speed), _halves(self, speed)
            parts = np.split(track[0] + 1j * track[1], [dynamics.symmetric])
            track = _parts(
                np.concatenate([to.carried(old, r) for to, old, r in zip(after, before, parts, strict=True)])
            )
        return self._at(dynamics.wheel_state, track, dx, speed, behind)

    def _at(self, wheel_state: Real, track_state: Real, dx: float, speed: float, behind: float) -> Causal:
        dt = dx / speed
        poles, inputs, outputs = self.wheelset.poles, self.wheelset.inputs, self.wheelset.outputs
        a, (b0, _), (_, b1) = np.exp(poles * dt), hold_coefficients(poles, dt), hold_coefficients(poles, dx / behind)
        wheel_compliance = (outputs * b1 * inputs.T).real.sum(axis=1) + self.wheel_residual
        stress_direct = (self.stress_output @ (b1[:, np.newaxis] * inputs)).real + self.stress_feedthrough
        ahead, back = _halves(self, speed), _halves(self, behind)
        tables = [_track_tables(half, old, dx, speed, behind) for half, old in zip(ahead, back, strict=True)]
        at_once = [table.at_once + half.residual for table, half in zip(tables, self.track.halves, strict=True)]
        return Causal(
            wheel_state=wheel_state,
            wheel_factor=_parts(a),
            wheel_gain=_parts(((a * b1 + b0)[:, np.newaxis] * inputs).T),
            wheel_output=_parts(outputs),
            track_state=track_state,
            track_factor=_parts(np.concatenate([table.factor for table in tables])),
            track_input=_parts(np.concatenate([table.input for table in tables], axis=1)),
            track_output=_parts(np.concatenate([half.output for half in ahead], axis=1)),
            symmetric=len(ahead[0].poles),
            stress_output=_parts(self.stress_output),
            stress_direct=stress_direct,
            wheel_compliance=wheel_compliance,
            rail_compliance=(at_once[0] + at_once[1]) / 2,
            speed=speed,
        )


class _TrackTables(NamedTuple):
    factor: Complex  # (Q,)
    input: Complex  # (L, Q) what a unit force at a place adds to the predictor
    at_once: Real  # (L,) m/N of the force at the same step


@lru_cache(maxsize=64)
def _halves(model: CausalModel, speed: float) -> tuple[HalfModes, HalfModes]:
    return model.track.symmetric.modes(speed), model.track.antisymmetric.modes(speed)


def _track_tables(ahead: HalfModes, behind: HalfModes, dx: float, speed: float, speed_behind: float) -> _TrackTables:
    """Step of half a track: ``r <- a r + input F`` with ``input = a b1 s + b0 s``, b1 of the interval behind."""
    dt = dx / speed
    a = np.exp(ahead.poles * dt)
    b1 = hold_coefficients(behind.poles, dx / speed_behind)[1]
    held = b1 * behind.input
    at_once = np.asarray((behind.output * held).real.sum(axis=1))
    if ahead is not behind:
        held = ahead.carried(behind, held)
    return _TrackTables(a, a * held + hold_coefficients(ahead.poles, dt)[0] * ahead.input, at_once)


def causal_model(wheelset: ReducedWheelset, track: MovingTrack, nodes: Sequence[str], lag_zero: str) -> CausalModel:
    """Join the reduced models; raises InputError for a stress node that the wheelset does not have.

    ``lag_zero`` is a variant of ``scenario.LAG_ZERO``: which residuals displace the contacts at the force's instant.
    """
    rows, kept = stress_rows(wheelset, nodes)
    own = np.diag(wheelset.displacement_residual)
    return CausalModel(
        wheelset=wheelset,
        track=track.without_residual() if lag_zero == "zero" else track,
        wheel_residual=own if lag_zero == "wheel_residual" else np.zeros_like(own),
        stress_output=wheelset.stress_outputs[rows].reshape(-1, len(wheelset.poles))[kept],
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


def _parts(values: Complex) -> Real:
    """Real and imaginary parts stacked in front, contiguous."""
    return np.ascontiguousarray(np.stack([values.real, values.imag]))
