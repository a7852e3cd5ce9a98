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

from ..one_core import on_one_core
from ..structures.reduced_wheelset import ReducedWheelset
from ..structures.track_balance import HalfModes, MovingTrack
from .causal_kernels import ROW, Causal
from .hold import hold
from .stress_rows import stress_rows

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

REGISTER = 8
"""Numbers in the widest vector register; banks begin on the border of one and are filled in whole ones."""

STATIC_STRESS = 5e-4
"""Share of the largest static stress that modes may hold together to answer at once instead of being summed up."""


@dataclass(frozen=True, eq=False)
class CausalModel:
    """Reduced models of one wheelset and one track, ready to be stepped at any speed.

    P wheelset modes, L steps a bay, S stress components.
    """

    wheelset: ReducedWheelset
    track: MovingTrack
    wheel_residual: Real  # (2,) m/N of the wheels
    stress_output: Complex  # (S, R) of the first R modes; the others answer at once
    stress_feedthrough: Real  # (S, 2)
    stress_rows: NDArray[np.intp]  # (S,) where the components stand in the flattened (nodes, 6)
    changes_speed: ClassVar[bool] = True
    longest_run: ClassVar[float] = math.inf

    @on_one_core
    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        wheels = self.wheelset.static_receptance().sum(axis=1) + self.wheel_residual
        displacement: Real = (wheels + self.track.symmetric.compliance().mean()) * wheel_load
        return displacement

    @on_one_core
    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Causal:
        """Dynamics at ``speed`` m/s and in equilibrium with ``wheel_load`` N standing on both wheels at ``step``."""
        poles, dt = self.wheelset.poles, dx / speed
        load = self.wheelset.inputs.sum(axis=1) * wheel_load
        wheel = -load / poles - hold(poles, dt).after * load
        even, odd = _halves(self, speed)
        place = step % len(even.input)
        state = even.of_state(self.track.symmetric.standing(place, wheel_load))
        state -= hold(even.poles, dt).after * even.input[place] * wheel_load
        track = state, np.zeros_like(odd.poles)
        wheels = (self.wheelset.outputs @ wheel).real
        rail = (even.output[place] @ state).real
        return self._at(wheel, track, np.array([wheels, [rail, rail]]), dx, speed, speed)

    @on_one_core
    def at_speed(self, dynamics: Causal, step: int, dx: float, speed: float, behind: float) -> Causal:
        """Dynamics at another ``speed`` m/s, with the state of ``dynamics``, which has come to ``step``.

        For the one step at which the speed changes, ``behind`` is the speed with which that step was reached: what
        its own force displaces belongs to the interval behind it, everything else to the one ahead. What is returned
        then serves for that step alone, and has but its place of the bay.
        """
        before, after = _halves(self, dynamics.speed), _halves(self, speed)
        wheel = _unbanked(dynamics.wheels, len(self.wheelset.poles))
        states = [_unbanked(r, len(of.poles)) for r, of in zip(dynamics.track, before, strict=True)]
        if dynamics.speed != speed:
            states = [to.carried(old, r) for to, old, r in zip(after, before, states, strict=True)]
        crossing = None if behind == speed else _track_steps_at(self, [step], dx, speed, behind)
        return self._at(wheel, states, dynamics.coming, dx, speed, behind, crossing)

    @on_one_core
    def prepare(self, dx: float, speed: float) -> None:
        """Work out what every run at ``speed`` m/s needs, and keep it for a while: ``at_speed`` is short then."""
        _track_steps(self, dx, speed)

    def _at(
        self,
        wheel: Complex,
        track: Sequence[Complex],
        coming: Real,
        dx: float,
        speed: float,
        behind: float,
        crossing: _TrackSteps | None = None,
    ) -> Causal:
        dt = dx / speed
        poles, inputs, outputs = self.wheelset.poles, self.wheelset.inputs, self.wheelset.outputs
        (a, b0, _), b1 = hold(poles, dt), hold(poles, dx / behind).after
        wheel_compliance = (outputs * b1 * inputs.T).real.sum(axis=1) + self.wheel_residual
        summed, groups = self.stress_output.shape[1], -(-len(self.stress_output) // 4)
        stress_direct = (self.stress_output @ (b1[:summed, np.newaxis] * inputs[:summed])).real
        gains = ((a * b1 + b0)[:, np.newaxis] * inputs).T
        track_steps = crossing or _track_steps(self, dx, speed)
        halves = [np.stack([r, factor]) for r, factor in zip(track, track_steps.factors, strict=True)]
        return Causal(
            wheels=_banked(np.stack([wheel, a, *gains, *outputs])),
            wheel_modes=_whole_registers(len(poles)),
            track=_banked(_side_by_side(halves)),
            places=track_steps.places,
            track_modes=_whole_registers(max(len(r) for r in track)),
            coming=coming,
            stress_output=_banked(_padded(self.stress_output, 0, 4 * groups).reshape(groups, 4, summed)),
            stress_modes=_whole_registers(summed),
            stress_direct=stress_direct + self.stress_feedthrough,
            wheel_compliance=wheel_compliance,
            rail_compliance=track_steps.at_once,
            speed=speed,
        )


@lru_cache(maxsize=16)
def _halves(model: CausalModel, speed: float) -> tuple[HalfModes, HalfModes]:
    return model.track.symmetric.modes(speed), model.track.antisymmetric.modes(speed)


class _TrackSteps(NamedTuple):
    """Coefficients of steps of the track at L places of the bay."""

    factors: tuple[Complex, ...]  # (Q,) of each half
    places: Real  # as in ``Causal``
    at_once: Real  # (L,) m/N of the force at the same step


@lru_cache(maxsize=8)
def _track_steps(model: CausalModel, dx: float, speed: float) -> _TrackSteps:
    """All places at one speed; kept, because wheelsets that run side by side share what is large."""
    return _track_steps_at(model, range(len(model.track.symmetric.input)), dx, speed, speed)


def _track_steps_at(model: CausalModel, steps: Sequence[int], dx: float, speed: float, behind: float) -> _TrackSteps:
    """Step of both halves: ``r <- a r + input F`` with ``input = a b1 s + b0 s``, b1 of the interval behind."""
    bay = len(model.track.symmetric.input)
    here, next_one = np.array(steps) % bay, (np.array(steps) + 1) % bay
    factors, places, at_once = [], [], 0.0
    for ahead, back, half in zip(_halves(model, speed), _halves(model, behind), model.track.halves, strict=True):
        a, b0, _ = hold(ahead.poles, dx / speed)
        held = hold(back.poles, dx / behind).after * back.input[here]
        at_once = at_once + ((back.output[here] * held).real.sum(axis=1) + half.residual[here]) / 2
        if behind != speed:
            held = ahead.carried(back, held)
        into = a * held + b0 * ahead.input[here]
        factors.append(a)
        places.append(np.stack([into, ahead.output[next_one]], axis=1))
    return _TrackSteps(tuple(factors), _banked(_side_by_side(places)), np.asarray(at_once))


def causal_model(wheelset: ReducedWheelset, track: MovingTrack, nodes: Sequence[str], lag_zero: str) -> CausalModel:
    """Join the reduced models; raises InputError for a stress node that the wheelset does not have.

    ``lag_zero`` is a variant of ``scenario.LAG_ZERO``: which residuals displace the contacts at the force's instant.
    """
    nodes_at, kept = stress_rows(wheelset, nodes)
    wheelset, summed = _by_static_stress(wheelset, nodes_at)
    stress_outputs = wheelset.stress_outputs[nodes_at].reshape(-1, len(wheelset.poles))[kept]
    at_once = -(stress_outputs[:, summed:] @ (wheelset.inputs[summed:] / wheelset.poles[summed:, np.newaxis])).real
    own = np.diag(wheelset.displacement_residual)
    return CausalModel(
        wheelset=wheelset,
        track=track.without_residual() if lag_zero == "zero" else track,
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
        stress_feedthrough=wheelset.stress_feedthrough - (wheelset.stress_outputs[..., ~kept] @ left_out).real,
        displacement_residual=wheelset.displacement_residual - (wheelset.outputs[:, ~kept] @ left_out).real,
    )


def _side_by_side(halves: Sequence[Complex]) -> Complex:
    """Rows of modes of both halves of the track, (..., K, modes) each, in one length: (..., 2, K, Q)."""
    longest = max(half.shape[-1] for half in halves)
    return np.stack([_padded(half, -1, longest) for half in halves], axis=-3)


def _whole_registers(modes: int) -> int:
    return -(-modes // REGISTER) * REGISTER


def _padded(values: Complex, axis: int, length: int) -> Complex:
    widths = [(0, 0)] * values.ndim
    widths[axis] = (0, length - values.shape[axis])
    return np.pad(values, widths)


def _banked(rows: Complex) -> Real:
    """Rows of modes, (..., K, modes), as banks of real and imaginary parts: (..., banks, 2 K ROW), aligned memory."""
    banks = -(-rows.shape[-1] // ROW)
    split = _padded(rows, -1, banks * ROW).reshape(*rows.shape[:-1], banks, ROW)
    parts = np.stack([split.real, split.imag], axis=-3)  # (..., K, 2, banks, ROW)
    parts = np.moveaxis(parts, -2, -4)
    memory = np.zeros(parts.size + REGISTER)
    first = -memory.ctypes.data // memory.itemsize % REGISTER
    aligned = memory[first : first + parts.size]
    aligned.reshape(parts.shape)[...] = parts
    return aligned.reshape(*rows.shape[:-2], banks, 2 * rows.shape[-2] * ROW)


def _unbanked(banks: Real, modes: int) -> Complex:
    """First of the rows that ``_banked`` has laid out as (banks, 2 K ROW): (modes,)."""
    values: Complex = (banks[:, :ROW] + 1j * banks[:, ROW : 2 * ROW]).ravel()[:modes]
    return values
