"""Least squares for one kind of damage: sizes, and of each observation place, lateral place, lag, gain and speed.

All unknowns have a prior. Sizes and places are equally likely within their ranges. Lateral places, gains, speeds and
the properties of the track are normal about what is given, and enter as residuals of unit variance. With the residuals
r of samples and priors, and their Jacobian J, the posterior about an optimum is normal with the covariance (J' J)^-1
(Laplace), and the evidence of the kind is::

    log Z = -r' r / 2 + log prior + (d log 2 pi - log det J' J) / 2

Columns of J for sizes and places are differences of simulations; those of lag, gain, speed and track need none.

A model is not what was measured. The track is uncertain by unknowns of its own, whose effects are simulated. What is
left of the model's errors has the standard deviation ``shape``, a share of how far a sample is from the median, and the
correlation exp(-|t| / 1 ms): such errors last as the vibrations do to which they belong, and are not averaged out as
the white noise of the sensor is. Where a wheelset rings, phases drift, and the distance is that of its amplitude. So
the covariance of the samples is::

    C = sigma^2 I + D K D,    D = shape diag(|y - median|),    K_ij = exp(-|t_i - t_j| / 1 ms)

Residuals are whitened by its Cholesky factor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.ndimage import uniform_filter1d
from scipy.optimize import least_squares

from ..irregularities import Irregularity
from ..runtime.arrays import Real
from .forward import SPAN, Forward, PassageCurve
from .kinds import LATERAL, DamageKind

SIZE_STEP, PLACE_STEP, LATERAL_STEP = 0.02, 0.010, 0.1
"""Steps of differences: of z, of the place in m, of the lateral place in standard deviations."""
LAG_UNIT = 1e-3
"""Lags are looked for in ms."""
LAGS = 0.1e-3 * np.arange(-8, 9)
"""Lags about that of the peaks that are tried first, s."""
PLACES = 4
"""Places on the bay from which searches begin."""
LATERALS = (0.3, 1.3)
"""The same of lateral places, standard deviations."""
ROUGH = 0.10
"""Share by which simulations of a first guess may be off."""
SHAPE_TIME = 1e-3
"""Time over which errors of the model belong together, s."""
AMPLITUDE = 5e-3
"""Time before and after a sample over which the amplitude of a ringing wheelset is taken, s."""
STEPS = 16
"""Steps of a search."""
ENOUGH = 1e-4
"""Share of the sum of squares by which a step has to lower it, or the search ends. In the narrow valley of depth and
width, steps are many and small: some 500 samples then end within 0.1 of the lowest."""


@dataclass(frozen=True, eq=False)
class Optimum:
    """A local optimum."""

    x: Real
    """(d,) unknowns, in the order of ``Problem.names``."""
    covariance: Real
    """(d, d)"""
    chi2: float
    """Sum of squared residuals of all samples."""
    log_evidence: float
    jacobian: Real
    """(samples, d) of the residuals of the samples."""
    residuals: Real
    """(samples,)"""


class Problem:
    """Fit of one kind to some observations; None as kind is a wheel without damage."""

    def __init__(self, kind: DamageKind | None, forwards: Sequence[Forward], parts: int) -> None:
        """``parts`` is the number of uncertain properties of the track."""
        self.kind, self.forwards, self.parts = kind, tuple(forwards), parts
        self.sizes = len(kind.unknowns) if kind else 0
        lateral = bool(kind and kind.lateral)
        self.per = ("place", *(("lateral",) if lateral else ()), *(("lag",) if kind else ()), "gain", "speed")
        """Unknowns of each observation."""
        sizes = [each.name for each in kind.unknowns] if kind else []
        self.names = (
            *sizes,
            *(f"{name} {number}" for number in range(len(forwards)) for name in self.per),
            *(f"track {number}" for number in range(parts)),
        )
        self.scale = [np.hypot(each.observation.sigma, _shape(each)) for each in self.forwards]
        """Standard deviation of the samples of each observation."""
        self._roots = [_root(each) for each in self.forwards]
        self.samples = sum(len(each.values) for each in self.forwards)
        self.of_track = [np.zeros((parts, len(each.values))) for each in self.forwards]
        """What a standard deviation of each property of the track adds to an observation, (parts, n): linear part."""
        self.bent = [np.zeros_like(each) for each in self.of_track]
        """The same, quadratic part."""
        bounds = np.tile([-np.inf, np.inf], (len(self.names), 1))
        if kind:
            bounds[: self.sizes] = kind.bounds
        for number in range(len(forwards)):
            bounds[self.at(number, "speed")] = -1.5 * SPAN, 1.5 * SPAN
        self.bounds = bounds

    def at(self, number: int, name: str) -> int:
        """Place of an observation's unknown in x."""
        return self.sizes + number * len(self.per) + self.per.index(name)

    @property
    def track(self) -> slice:
        """Unknowns of the track in x."""
        return slice(len(self.names) - self.parts, len(self.names))

    def damage(self, number: int, x: Real) -> Irregularity | None:
        """Damage as an observation met it."""
        if self.kind is None:
            return None
        forward = self.forwards[number]
        y = LATERAL * x[self.at(number, "lateral")] if self.kind.lateral else 0.0
        angle = forward.angle(x[self.at(number, "place")])
        return self.kind.make(forward.observation.wheel, self.kind.values(x[: self.sizes]), angle, y)

    def curve(self, number: int, x: Real, speed: int, track: int = 0) -> PassageCurve:
        """Simulated curve of an observation."""
        forward = self.forwards[number]
        return forward.curve(self.damage(number, x), x[self.at(number, "place")] % forward.bay, speed, track)

    def _lag(self, number: int, x: Real) -> float:
        return LAG_UNIT * float(x[self.at(number, "lag")]) if self.kind else 0.0

    def _speed(self, number: int, x: Real) -> float:
        given = self.forwards[number].observation
        return given.speed * (1.0 + given.speed_error * float(x[self.at(number, "speed")]))

    def signal(self, number: int, x: Real, speeds: Sequence[tuple[int, float]], derivative: int = 0) -> Real:
        """Signal (n,) with gain 1 on the given track: weighted mean of the curves at some speeds."""
        forward, lag, v = self.forwards[number], self._lag(number, x), self._speed(number, x)
        parts = [
            weight * forward.at(self.curve(number, x, speed), lag, v, derivative)
            for speed, weight in speeds
            if weight != 0.0
        ]
        total: Real = np.sum(parts, axis=0)
        return total

    def predicted(self, number: int, x: Real, derivative: int = 0) -> Real:
        """Observed signal (n,), track included and without the gain."""
        forward = self.forwards[number]
        plain = self.signal(number, x, forward.weights(float(x[self.at(number, "speed")])), derivative)
        return plain if derivative else plain + self.by_track(number, x)

    def by_track(self, number: int, x: Real) -> Real:
        """What the track adds to an observation, (n,)."""
        off = x[self.track]
        added: Real = off @ self.of_track[number] + off**2 @ self.bent[number]
        return added

    def gain(self, number: int, x: Real) -> float:
        """Of an observation."""
        return 1.0 + self.forwards[number].observation.gain_error * float(x[self.at(number, "gain")])

    def linearise_track(self, x: Real) -> None:
        """Simulate what the properties of the track change about x."""
        for number, forward in enumerate(self.forwards):
            speed = forward.nearest(float(x[self.at(number, "speed")]))
            lag, v = self._lag(number, x), self._speed(number, x)
            here = forward.at(self.curve(number, x, speed), lag, v)
            for part in range(self.parts):
                more, less = (
                    forward.at(self.curve(number, x, speed, sign * (part + 1)), lag, v) - here for sign in (1, -1)
                )
                self.of_track[number][part], self.bent[number][part] = (more - less) / 2, (more + less) / 2

    def whitened(self, number: int, of_samples: Real) -> Real:
        """Numbers for each sample of an observation, (n,) or (n, d), with unit covariance where theirs is C."""
        white: Real = solve_triangular(self._roots[number], of_samples, lower=True, check_finite=False)
        return white

    def residuals(self, x: Real) -> Real:
        """Of all samples, whitened, (samples,)."""
        found = [
            self.whitened(number, self.gain(number, x) * self.predicted(number, x) - forward.values)
            for number, forward in enumerate(self.forwards)
        ]
        return np.concatenate(found)

    @property
    def normal(self) -> list[int]:
        """Unknowns with a normal prior of unit variance."""
        of_each = [name for name in ("lateral", "gain", "speed") if name in self.per]
        own = [self.at(number, name) for number in range(len(self.forwards)) for name in of_each]
        return [*own, *range(self.track.start, self.track.stop)]

    def jacobian(self, x: Real) -> Real:
        """Of the residuals of the samples, (samples, d)."""
        rows = [self.whitened(number, self.slopes(number, x)) for number in range(len(self.forwards))]
        return np.concatenate(rows)

    def slopes(self, number: int, x: Real) -> Real:
        """Derivatives of the observed signal with respect to x, (n, d)."""
        forward, gain = self.forwards[number], self.gain(number, x)
        found = np.zeros((len(forward.values), len(x)))
        near = [(forward.nearest(float(x[self.at(number, "speed")])), 1.0)]
        here = self.signal(number, x, near)
        for column, step in self._steps(number, x):
            moved = x.copy()
            moved[column] += step
            found[:, column] = gain * (self.signal(number, moved, near) - here) / step
        if self.kind:
            found[:, self.at(number, "lag")] = -gain * LAG_UNIT * self.predicted(number, x, 1)
        observation = forward.observation
        found[:, self.at(number, "gain")] = observation.gain_error * self.predicted(number, x)
        if len(forward.speeds) > 1:
            sides = self.signal(number, x, [(0, -1.0), (1, 1.0)])
            found[:, self.at(number, "speed")] = gain * sides / (2 * forward.width)
            if observation.on_wheelset:  # hits come at other times as well
                moved = x.copy()
                moved[self.at(number, "speed")] += 0.01
                change = self.signal(number, moved, near) - here
                found[:, self.at(number, "speed")] += gain * change / 0.01
        bent = 2 * x[self.track, np.newaxis] * self.bent[number]
        found[:, self.track] = gain * (self.of_track[number] + bent).T
        return found

    def _steps(self, number: int, x: Real) -> Iterator[tuple[int, float]]:
        """Unknowns whose columns are differences of simulations, with their steps."""
        for column in range(self.sizes):
            step = SIZE_STEP if x[column] + SIZE_STEP <= self.bounds[column, 1] else -SIZE_STEP
            yield column, step
        yield self.at(number, "place"), PLACE_STEP
        if "lateral" in self.per:
            yield self.at(number, "lateral"), LATERAL_STEP

    def search(self, start: Real, steps: int = STEPS) -> Optimum:
        """The local optimum that is reached from ``start`` in some steps."""
        self.linearise_track(start)
        normal, rows = self.normal, np.eye(len(start))[self.normal]

        def off(at: Real) -> Real:
            return np.concatenate([self.residuals(at), at[normal]])

        def slope(at: Real) -> Real:
            return np.concatenate([self.jacobian(at), rows])

        found = least_squares(
            off,
            np.clip(start, self.bounds[:, 0] + 1e-9, self.bounds[:, 1] - 1e-9),
            slope,
            bounds=(self.bounds[:, 0], self.bounds[:, 1]),
            x_scale=self._scales,
            max_nfev=steps,
            ftol=ENOUGH,
            xtol=1e-4,
            gtol=1e-6,
        )
        return self.optimum(found.x)

    @property
    def _scales(self) -> Real:
        scales = np.ones(len(self.names))
        scales[: self.sizes] = 0.2
        for number in range(len(self.forwards)):
            scales[self.at(number, "place")] = 0.1
            if self.kind:
                scales[self.at(number, "lag")] = 0.1
        return scales

    @property
    def widths(self) -> Real:
        """(d,) widths of the uniform priors; 0 for a normal one."""
        widths = np.zeros(len(self.names))
        widths[: self.sizes] = self.bounds[: self.sizes, 1] - self.bounds[: self.sizes, 0]
        for number, forward in enumerate(self.forwards):
            widths[self.at(number, "place")] = forward.bay
            if self.kind:
                widths[self.at(number, "lag")] = (forward.time[-1] - forward.time[0]) / LAG_UNIT
        return widths

    def optimum(self, x: Real) -> Optimum:
        """What Laplace says about an optimum."""
        residuals, jacobian = self.residuals(x), self.jacobian(x)
        widths, normal = self.widths, self.normal
        precision = np.where(widths > 0, 12.0 / np.maximum(widths, 1e-12) ** 2, 1.0)
        covariance = np.linalg.inv(jacobian.T @ jacobian + np.diag(precision))
        covariance = (covariance + covariance.T) / 2
        chi2 = float(residuals @ residuals)
        log_prior = -0.5 * float(x[normal] @ x[normal]) - 0.5 * len(normal) * math.log(2 * math.pi)
        log_prior -= float(np.log(widths[widths > 0]).sum())
        volume = 0.5 * (len(x) * math.log(2 * math.pi) + float(np.linalg.slogdet(covariance)[1]))
        return Optimum(x, covariance, chi2, -0.5 * chi2 + log_prior + volume, jacobian, residuals)

    def starts(self, most: int) -> list[Real]:
        """First guesses, the best ones first: sizes and places of the kind that come near to all observations."""
        found: list[tuple[float, Real]] = []
        for sizes in self.kind.starts if self.kind else ((),):
            x = np.zeros(len(self.names))
            if self.kind:
                x[: self.sizes] = self.kind.coordinates(sizes)
            found.append((sum(self._placed(number, x, 1) for number in range(len(self.forwards))), x))
        nearest = sorted(found, key=lambda each: each[0])[: most + 1]
        found = [(sum(self._placed(number, x, PLACES) for number in range(len(self.forwards))), x) for _, x in nearest]
        return [x for _, x in sorted(found, key=lambda each: each[0])[:most]]

    def _placed(self, number: int, x: Real, places: int) -> float:
        """Put the best place, lateral place and lag of an observation into x; returns its rough sum of squares."""
        forward = self.forwards[number]
        speed = forward.nearest(0.0)
        scale = np.hypot(self.scale[number], ROUGH * _away(forward.values))
        best, chosen = math.inf, x.copy()
        for place in forward.bay * np.arange(places) / places:
            for lateral in LATERALS if "lateral" in self.per else (0.0,):
                x[self.at(number, "place")] = place
                if "lateral" in self.per:
                    x[self.at(number, "lateral")] = lateral
                curve = self.curve(number, x, speed)
                for lag in -curve.peak + LAGS if self.kind else (0.0,):
                    off = (forward.at(curve, lag, forward.observation.speed) - forward.values) / scale
                    if (score := float(off @ off)) < best:
                        if self.kind:
                            x[self.at(number, "lag")] = lag / LAG_UNIT
                        best, chosen = score, x.copy()
        x[:] = chosen
        return best


def _root(forward: Forward) -> Real:
    """Cholesky factor of the covariance of an observation's samples, (n, n)."""
    error = _shape(forward)
    alike = np.exp(-np.abs(forward.time[:, np.newaxis] - forward.time) / SHAPE_TIME)
    covariance = error[:, np.newaxis] * alike * error + forward.observation.sigma**2 * np.eye(len(error))
    root: Real = np.linalg.cholesky(covariance)
    return root


def _shape(forward: Forward) -> Real:
    """Standard deviation of errors of the model (n,)."""
    away, observation = _away(forward.values), forward.observation
    if observation.on_wheelset:
        width = 2 * round(AMPLITUDE / observation.period) + 1
        away = np.sqrt(2.0 * uniform_filter1d(away**2, width, mode="nearest"))
    shape: Real = observation.shape * away
    return shape


def _away(values: Real) -> Real:
    away: Real = np.abs(values - np.median(values))
    return away
