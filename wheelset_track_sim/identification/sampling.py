"""Draws from the posterior of a kind: Laplace's normal as proposal, weighted by simulations, then resampled.

Only what has to be simulated is drawn: sizes, places and lateral places. For each draw, lag, gain, speed and track are
linear unknowns with normal priors, and are integrated out in closed form. Draws beyond a range are folded back at its
ends, and the density of the proposal is that of the folded normal. The weighted draws are resampled with a kernel that
keeps mean and covariance (J. Liu and M. West, in: Sequential Monte Carlo Methods in Practice, 2001, 197-223).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp
from scipy.stats import norm, qmc

from ..runtime.arrays import Real
from .fit import Optimum, Problem

DRAWS = 12
"""Draws that are simulated, for each size and place of one observation, and for two more."""
WIDER = 1.25
"""Factor on the standard deviations of the proposal."""
RESAMPLED = 500
"""Draws that are handed on."""
FEWEST = 3.0
"""Effective draws for each unknown below which Laplace's normal stands in: fewer make too small a covariance."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Equally likely draws of what is simulated."""

    columns: tuple[int, ...]
    """Their places in x."""
    draws: Real
    """(RESAMPLED, columns)"""
    effective: float
    """Effective number of draws that were simulated."""


def simulated_columns(problem: Problem) -> tuple[int, ...]:
    """Unknowns that have to be simulated."""
    places = [
        problem.at(number, name)
        for number in range(len(problem.forwards))
        for name in ("place", "lateral")
        if name in problem.per
    ]
    return (*range(problem.sizes), *places)


def sample(problem: Problem, modes: Sequence[Optimum], seed: int, draws: int | None = None) -> Posterior:
    """Posterior about some optima, in which the first one is the best."""
    columns = simulated_columns(problem)
    folded = _Folded(problem, modes, columns)
    proposed = folded.drawn(draws or DRAWS * (problem.sizes + 3), seed)
    log_weights = np.array([_log_posterior(problem, modes[0], columns, each) for each in proposed])
    log_weights -= folded.log_density(proposed)
    weights = np.exp(log_weights - logsumexp(log_weights))
    effective = float(1.0 / np.sum(weights**2)) if np.isfinite(weights).all() else 0.0
    random = np.random.default_rng(seed)
    if effective < FEWEST * len(columns):
        return Posterior(columns, folded.drawn(RESAMPLED, seed, wider=1.0), effective)
    mean = weights @ proposed
    away = proposed - mean
    covariance = (away.T * weights) @ away
    width = effective ** (-1.0 / (len(columns) + 4))
    keep = math.sqrt(max(0.0, 1.0 - width**2))
    chosen = random.choice(len(proposed), RESAMPLED, p=weights)
    noise = random.multivariate_normal(np.zeros(len(columns)), covariance, RESAMPLED, method="eigh")
    return Posterior(columns, folded.fold(mean + keep * away[chosen] + width * noise), effective)


class _Folded:
    """Mixture of normals about the optima, folded into the ranges of the sizes."""

    def __init__(self, problem: Problem, modes: Sequence[Optimum], columns: tuple[int, ...]) -> None:
        self._bounds = problem.bounds[list(columns)]
        evidence = np.array([mode.log_evidence for mode in modes])
        self._shares = np.exp(evidence - logsumexp(evidence))
        self._means = [mode.x[list(columns)] for mode in modes]
        self._roots = [np.linalg.cholesky(mode.covariance[np.ix_(columns, columns)]) for mode in modes]

    def drawn(self, count: int, seed: int, wider: float = WIDER) -> Real:
        """Draws (count, columns)."""
        dimensions = len(self._bounds)
        uniform = qmc.Sobol(dimensions + 1, seed=seed).random(1 << (count - 1).bit_length())[:count]
        normal = norm.ppf(np.clip(uniform[:, 1:], 1e-9, 1 - 1e-9))
        mode = np.minimum(np.searchsorted(np.cumsum(self._shares), uniform[:, 0]), len(self._shares) - 1)
        found = [self._means[at] + wider * self._roots[at] @ each for at, each in zip(mode, normal, strict=True)]
        return self.fold(np.array(found))

    def fold(self, draws: Real) -> Real:
        """Draws (n, columns) reflected at the ends of the ranges."""
        folded = draws.copy()
        for column, (low, high) in enumerate(self._bounds):
            if np.isfinite(low):
                off = np.mod(folded[:, column] - low, 2 * (high - low))
                folded[:, column] = low + np.minimum(off, 2 * (high - low) - off)
        return folded

    def log_density(self, draws: Real) -> Real:
        """Of the proposal, (n,), with the images of the draws behind the ends."""
        images = [self._images(column) for column in range(len(self._bounds))]
        parts = []
        for share, mean, root in zip(self._shares, self._means, self._roots, strict=True):
            inverse = np.linalg.inv(WIDER * root)
            constant = math.log(max(share, 1e-300)) + float(np.log(np.diag(inverse)).sum())
            for reflection in itertools.product(*images):
                at = np.array([sign for sign, _ in reflection]) * draws + np.array([offset for _, offset in reflection])
                parts.append(constant - 0.5 * np.sum(((at - mean) @ inverse.T) ** 2, axis=1))
        density: Real = logsumexp(np.array(parts), axis=0)
        return density

    def _images(self, column: int) -> list[tuple[float, float]]:
        low, high = self._bounds[column]
        return [(1.0, 0.0), (-1.0, 2 * low), (-1.0, 2 * high)] if np.isfinite(low) else [(1.0, 0.0)]


def _log_posterior(problem: Problem, mode: Optimum, columns: tuple[int, ...], drawn: Real) -> float:
    """Of a draw, with all that is linear integrated out, but for a constant."""
    own = list(columns)
    others = [column for column in range(len(mode.x)) if column not in columns]
    normal = [column for column in problem.normal if column not in columns]
    drift = mode.covariance[np.ix_(others, own)] @ np.linalg.solve(
        mode.covariance[np.ix_(own, own)], drawn - mode.x[own]
    )
    x = mode.x.copy()
    x[own], x[others] = drawn, mode.x[others] + drift
    residuals = np.concatenate([_residual(problem, number, x, mode) for number in range(len(problem.forwards))])
    prior = np.zeros((len(normal), len(others)))
    for row, column in enumerate(normal):
        prior[row, others.index(column)] = 1.0
    linear = np.concatenate([mode.jacobian[:, others], prior])
    target = np.concatenate([residuals, x[normal]])
    step, *_ = np.linalg.lstsq(linear, -target, rcond=None)
    left = target + linear @ step
    drawn_normal = [column for column in problem.normal if column in columns]
    return -0.5 * float(left @ left) - 0.5 * float(x[drawn_normal] @ x[drawn_normal])


def _residual(problem: Problem, number: int, x: Real, mode: Optimum) -> Real:
    """Of the samples of an observation, from one simulation: what the speed adds is that of the optimum."""
    forward, best = problem.forwards[number], mode.x
    near = [(forward.nearest(float(best[problem.at(number, "speed")])), 1.0)]
    of_speed = problem.predicted(number, best) - problem.by_track(number, best) - problem.signal(number, best, near)
    y = problem.signal(number, x, near) + of_speed + problem.by_track(number, x)
    return problem.whitened(number, problem.gain(number, x) * y - forward.values)
