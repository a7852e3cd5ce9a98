"""From the reduced models to the ``causal`` dynamics: coefficients of a step, states at rest, changes of speed.

A mode obeys ``q' = lambda q + g(t)`` with the modal load ``g`` taken linear between samples (first-order hold)::

    q[n+1] = a q[n] + b0 g[n] + b1 g[n+1]

The part that is known before the force of the step is ``r[n+1] = a q[n] + b0 g[n]``, so that ``q = r + b1 g`` and
``r[n+1] = a r[n] + (a b1 + b0) g[n]``; what ``b1 g`` displaces at once is a compliance at lag zero. The compliance at
lag zero from one wheel to the other is left out: it is 0.7 % of the direct one of the rails and 3e-5 of that of the
wheels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import Complex, Real
from ..runtime.one_core import on_one_core
from ..track.balance import MovingModes, MovingTrack
from ..wheelset.reduced import ReducedWheelset
from .banks import aligned, banked, padded, unbanked, whole_registers
from .causal_kernels import Causal
from .hold import hold
from .running_wheelset import RunningWheelset, running_wheelset


@dataclass(frozen=True, eq=False)
class CausalModel(RunningWheelset):
    """Reduced models of one wheelset and one track, ready to be stepped at any speed; L steps a bay."""

    track: MovingTrack

    @on_one_core
    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        displacement: Real = (self.static_wheels() + self.track.symmetric.compliance().mean()) * wheel_load
        return displacement

    @on_one_core
    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Causal:
        """Dynamics at ``speed`` m/s and in equilibrium with ``wheel_load`` N standing on both wheels at ``step``."""
        dt = dx / speed
        wheel = self.standing(wheel_load, dt)
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
        wheel = self.state_of(dynamics.wheels)
        states = [unbanked(r, len(of.poles)) for r, of in zip(dynamics.track, before, strict=True)]
        if dynamics.speed != speed:
            states = [to.carried(old, r) for to, old, r in zip(after, before, states, strict=True)]
        crossing = None if behind == speed else _track_steps_at(self, [step], dx, speed, behind)
        return self._at(wheel, states, dynamics.coming, dx, speed, behind, crossing)

    def copied(self, dynamics: Causal) -> Causal:
        """Dynamics in the same state that go on by themselves."""
        return dynamics._replace(
            wheels=aligned(dynamics.wheels), track=aligned(dynamics.track), coming=dynamics.coming.copy()
        )

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
        track_steps = crossing or _track_steps(self, dx, speed)
        halves = [np.stack([r, factor]) for r, factor in zip(track, track_steps.factors, strict=True)]
        return Causal(
            **self.at(wheel, dx, speed, behind)._asdict(),
            track=banked(_side_by_side(halves)),
            places=track_steps.places,
            track_modes=whole_registers(max(len(r) for r in track)),
            coming=coming,
            rail_compliance=track_steps.at_once,
            speed=speed,
        )


@lru_cache(maxsize=16)
def _halves(model: CausalModel, speed: float) -> tuple[MovingModes, MovingModes]:
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
    return _TrackSteps(tuple(factors), banked(_side_by_side(places)), np.asarray(at_once))


def causal_model(wheelset: ReducedWheelset, track: MovingTrack, nodes: Sequence[str], lag_zero: str) -> CausalModel:
    """Join the reduced models; raises InputError for a stress node that the wheelset does not have.

    ``lag_zero`` is a variant of ``scenario.LAG_ZERO``: which residuals displace the contacts at the force's instant.
    """
    running = running_wheelset(wheelset, nodes, lag_zero)
    return CausalModel(**vars(running), track=track.without_residual() if lag_zero == "zero" else track)


def _side_by_side(halves: Sequence[Complex]) -> Complex:
    """Rows of modes of both halves of the track, (..., K, modes) each, in one length: (..., 2, K, Q)."""
    longest = max(half.shape[-1] for half in halves)
    return np.stack([padded(half, -1, longest) for half in halves], axis=-3)
