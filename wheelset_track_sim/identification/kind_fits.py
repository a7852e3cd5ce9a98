"""Which damage explains what was measured: all kinds fitted, compared, and described by intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import logsumexp

from ..errors import InputError
from ..runtime.arrays import Real
from ..runtime.progress import Progress, unreported
from ..scenario import Scenario
from ..scenario.scenario import Wheel
from .fit import STEPS, Optimum, Problem
from .forward import Forward, TrackModels
from .kinds import KINDS, LATERAL, DamageKind, kinds_of
from .observation import Observation, PeakReading
from .peak import identify_peak
from .results import LEAST, TELLING, Band, Identification, Interval, KindFit, correlations, explains
from .sampling import sample, simulated_columns

TRACK_ERROR = 0.10
"""Standard deviation of stiffness and damping of pads and ballast, as a share."""
UNLIKELY = 25.0
"""Difference of the logarithms of evidence from which on a kind is not looked at more closely."""


def identify(
    data: Sequence[Observation] | PeakReading,
    scenario: Scenario,
    kinds: Sequence[str] = (),
    *,
    wheel: Wheel = "wheel_1",
    track_error: float = TRACK_ERROR,
    seed: int = 0,
    progress: Progress | None = None,
) -> Identification:
    """Find the damage that explains a peak, or some observations of one damage.

    Parameters
    ----------
    data
        Observations of passages of one wheelset with one damage on one wheel, or a peak alone.
    scenario
        Wheelset and track without the damage; speeds and loads are those of the data.
    kinds
        Kinds that are looked at, all if empty: ``flat``, ``worn_flat``, ``breakout``, ``none``.
    wheel
        The wheel of a peak.
    track_error
        Standard deviation of stiffness and damping of pads and ballast, as a share; 0 if the track is known.
    seed
        Of the draws: the same data and seed give the same result.
    progress
        Called with stage and fraction.

    Returns
    -------
    Identification
        Kinds with probabilities, sizes with 90 % intervals, and draws from which predictions are made.

    Raises
    ------
    InputError
        For kinds and data that cannot be used, and observations of different wheels.

    Examples
    --------
    >>> found = identify(PeakReading(force=250e3, speed=27.8), load_scenario("undamaged"), ["flat"])
    >>> length = found.best.parameters["length_m"]
    >>> length.low < 0.048 < length.high
    True
    """
    names, progress = kinds_of(kinds), progress or unreported
    if isinstance(data, PeakReading):
        return identify_peak(data, scenario, names, wheel=wheel, seed=seed, progress=progress)
    if not data:
        raise InputError("there is no observation: give one at least")
    wheels = {each.wheel for each in data}
    if len(wheels) > 1:
        raise InputError("the observations are of wheel_1 and wheel_2: give those of one wheel")
    tracks = TrackModels(scenario, track_error, progress)
    forwards = [Forward(each, tracks) for each in data]
    searched: dict[str, tuple[Problem, list[Optimum]]] = {}
    for number, name in enumerate(names):
        progress(f"search {name}", number / len(names))
        problem = Problem(KINDS.get(name), forwards, len(tracks.parts))
        searched[name] = problem, [problem.search(start, STEPS // 2) for start in problem.starts(1)]
    best = max(modes[0].log_evidence for _, modes in searched.values())
    known = max(searched.values(), key=lambda each: each[1][0].log_evidence)
    for number, forward in enumerate(forwards):
        if forward.observation.on_wheelset:
            forward.narrow(float(known[1][0].x[known[0].at(number, "speed")]))
    for problem, modes in searched.values():
        if modes[0].log_evidence > best - UNLIKELY:
            modes[:] = [problem.search(modes[0].x, STEPS)]
    fits = _compared(searched, seed, progress)
    progress("identified", 1.0)
    return Identification(
        scenario,
        data[0].wheel,
        fits,
        tuple(each.source for each in data),
        tuple(each.speed for each in data),
        tuple(each.axle_load for each in data),
        sum(each.simulated for each in forwards),
    )


def _compared(
    searched: Mapping[str, tuple[Problem, list[Optimum]]], seed: int, progress: Progress
) -> tuple[KindFit, ...]:
    """Fits of all kinds, the likeliest first."""
    evidence = {name: logsumexp([mode.log_evidence for mode in modes]) for name, (_, modes) in searched.items()}
    total = logsumexp([*evidence.values()])
    order = sorted(searched, key=lambda name: -evidence[name])
    found = []
    for number, name in enumerate(order):
        progress(f"sample {name}", number / len(order))
        problem, modes = searched[name]
        probability = math.exp(evidence[name] - total)
        shown = number == 0 or probability >= LEAST
        found.append(_described(name, problem, modes, probability, seed, shown=shown))
    return tuple(found)


def _described(
    name: str, problem: Problem, modes: list[Optimum], probability: float, seed: int, *, shown: bool
) -> KindFit:
    """Fit of a kind; with its bands if it is shown."""
    mode, kind = modes[0], problem.kind
    count, sizes = problem.samples, problem.sizes
    columns = simulated_columns(problem)
    if kind and probability >= LEAST:
        posterior = sample(problem, modes, seed)
        draws = posterior.draws
    else:
        random = np.random.default_rng(seed)
        covariance = mode.covariance[np.ix_(columns, columns)]
        draws = random.multivariate_normal(mode.x[list(columns)], covariance, 200, method="eigh")
    parameters, values = _sizes(kind, problem, draws[:, :sizes])
    laterals = np.zeros((len(draws), len(problem.forwards)))
    for number, forward in enumerate(problem.forwards):
        behind = f"_{number + 1}" if len(problem.forwards) > 1 else ""
        place = columns.index(problem.at(number, "place"))
        parameters[f"place{behind}_m"] = _around(draws[:, place], forward.bay)
        if "lateral" in problem.per:
            lateral = columns.index(problem.at(number, "lateral"))
            laterals[:, number] = np.abs(draws[:, lateral]) * LATERAL
            told = laterals[:, number].std() < TELLING * LATERAL * math.sqrt(1 - 2 / math.pi)
            parameters[f"lateral{behind}_m"] = Interval.of(laterals[:, number], bool(told))
    chi2 = mode.chi2 / count
    return KindFit(
        name,
        kind.meaning if kind else "no damage",
        probability,
        chi2,
        explains(chi2),
        parameters,
        correlations(kind, draws[:, :sizes]),
        values,
        laterals,
        tuple(_band(problem, mode, number) for number in range(len(problem.forwards))) if shown else (),
    )


def _sizes(kind: DamageKind | None, problem: Problem, z: Real) -> tuple[dict[str, Interval], Real]:
    """Intervals of the sizes of draws z (n, sizes), and their values."""
    if kind is None:
        return {}, np.zeros((len(z), 0))
    values = np.stack([each.value(z[:, at]) for at, each in enumerate(kind.unknowns)], axis=-1)
    found = {}
    for at, each in enumerate(kind.unknowns):
        before = problem.widths[at] / math.sqrt(12.0)
        found[each.name] = Interval.of(values[:, at], bool(z[:, at].std() < TELLING * before))
    return found, values


def _around(places: Real, bay: float) -> Interval:
    """Interval of places on a bay, whose ends are one: low may be negative."""
    angles = 2 * math.pi * places / bay
    middle = math.atan2(float(np.sin(angles).mean()), float(np.cos(angles).mean())) / (2 * math.pi) * bay
    away = np.mod(places - middle + bay / 2, bay) - bay / 2
    interval = Interval.of(away, bool(away.std() < TELLING * bay / math.sqrt(12.0)))
    shift = middle % bay
    return Interval(interval.estimate + shift, interval.low + shift, interval.high + shift, interval.told)


def _band(problem: Problem, mode: Optimum, number: int) -> Band:
    forward = problem.forwards[number]
    rows = problem.slopes(number, mode.x)
    variance = np.einsum("nd,de,ne->n", rows, mode.covariance, rows)
    fitted = problem.gain(number, mode.x) * problem.predicted(number, mode.x)
    spread = np.sqrt(np.maximum(variance, 0.0) + problem.scale[number] ** 2)
    return Band(forward.observation, forward.time, forward.values, fitted, spread)
