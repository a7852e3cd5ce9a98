"""What one peak force says: all sizes that make it, wherever on the bay and however far to the side it strikes.

Each kind is simulated at some tens of sizes, places and lateral places, spread evenly (Sobol). The logarithm of the
peak is interpolated between them by radial basis functions, whose error is measured by leaving some out. Draws from
all that was possible before are weighted by how near their peaks are to the reading.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.special import ndtri
from scipy.stats import qmc

from ..runtime.arrays import Real
from ..runtime.progress import Progress
from ..scenario import WHEELS, Scenario
from ..scenario.scenario import Wheel
from ..simulation.passages import Passages
from .kinds import KINDS, LATERAL, NONE, DamageKind
from .observation import PeakReading
from .results import TELLING, Identification, Interval, KindFit, correlations, explains

SIMULATED = {1: 64, 2: 96, 3: 160}
"""Passages of a kind by its number of sizes."""
LEFT_OUT = 8
"""Every this many simulations is left out to measure the error of the interpolation."""
TRIED = 20_000
"""Draws that are weighted."""
KEPT = 500
FARTHEST = 3.0
"""Largest lateral place, in its standard deviations."""
ROUND = 0.2
"""Radius of a bay in the coordinates of the interpolation, where the range of a size is 1."""
BEFORE, AFTER = 0.35, 0.8
"""Track before a place on the bay, and behind a whole bay, m."""


def identify_peak(
    reading: PeakReading, scenario: Scenario, names: Sequence[str], *, wheel: Wheel, seed: int, progress: Progress
) -> Identification:
    """See ``identify``."""
    passages = Passages(scenario, progress, before=BEFORE, after=scenario.track.spacing + AFTER)
    fits: list[tuple[float, KindFit]] = []
    for number, name in enumerate(names):
        progress(f"simulate {name}", number / len(names))
        fits.append(_fitted(name, reading, passages, wheel, seed))
    total = sum(likelihood for likelihood, _ in fits)
    shares = [likelihood / total if total > 0 else 1 / len(fits) for likelihood, _ in fits]
    found = [fit.of_probability(share) for (_, fit), share in zip(fits, shares, strict=True)]
    progress("identified", 1.0)
    return Identification(
        scenario,
        wheel,
        tuple(sorted(found, key=lambda fit: -fit.probability)),
        ("one peak",),
        (reading.speed,),
        (reading.axle_load,),
        sum(SIMULATED.get(len(KINDS[name].unknowns), 0) if name in KINDS else 1 for name in names),
    )


def _fitted(name: str, reading: PeakReading, passages: Passages, wheel: Wheel, seed: int) -> tuple[float, KindFit]:
    """Mean likelihood of a kind, and what the reading says about it."""
    kind = KINDS.get(name)
    if kind is None:
        forces = passages.run((), speed=reading.speed, axle_load=reading.axle_load).forces
        nearest = ((reading.force - forces[:, WHEELS.index(wheel)].max()) / reading.spread) ** 2
        likelihood = math.exp(-0.5 * nearest)
        fit = KindFit(NONE, "no damage", 0.0, nearest, explains(nearest), {}, {}, np.zeros((1, 0)), np.zeros((1, 1)))
        return likelihood, fit
    unit = _spread(kind, SIMULATED[len(kind.unknowns)], seed)
    peaks = np.array([_peak(kind, each, reading, passages, wheel) for each in unit])
    points, logs = _features(kind, unit), np.log(peaks)
    kept = np.arange(len(unit)) % LEFT_OUT > 0
    trial = RBFInterpolator(points[kept], logs[kept])
    error = float(np.sqrt(np.mean((trial(points[~kept]) - logs[~kept]) ** 2)))
    tried = _spread(kind, TRIED, seed + 1)
    found = np.exp(RBFInterpolator(points, logs)(_features(kind, tried)))
    spread = np.hypot(reading.spread, error * reading.force)
    off = ((found - reading.force) / spread) ** 2
    weights = np.exp(-0.5 * (off - off.min()))
    chosen = np.random.default_rng(seed).choice(len(tried), KEPT, p=weights / weights.sum())
    z = _sizes_of(kind, tried[chosen])
    values = np.stack([each.value(z[:, at]) for at, each in enumerate(kind.unknowns)], axis=-1)
    laterals = FARTHEST * LATERAL * tried[chosen, -1:] if kind.lateral else np.zeros((KEPT, 1))
    widths = np.ptp(kind.bounds, axis=1)
    parameters = {
        each.name: Interval.of(values[:, at], bool(z[:, at].std() < TELLING * widths[at] / math.sqrt(12)))
        for at, each in enumerate(kind.unknowns)
    }
    least = float(off.min())
    fit = KindFit(name, kind.meaning, 0.0, least, explains(least), parameters, correlations(kind, z), values, laterals)
    return float(np.mean(np.exp(-0.5 * off))), fit


def _spread(kind: DamageKind, count: int, seed: int) -> Real:
    """Sizes, place and lateral place, each from 0 to 1, spread evenly: (count, sizes + 1 or 2)."""
    columns = len(kind.unknowns) + 1 + kind.lateral
    uniform = qmc.Sobol(columns, seed=seed).random(1 << (count - 1).bit_length())[:count]
    if kind.lateral:  # half normal, cut off at the farthest
        inside = 0.5 + uniform[:, -1] * 0.4986
        uniform[:, -1] = np.clip(ndtri(inside) / FARTHEST, 0.0, 1.0)
    return uniform


def _sizes_of(kind: DamageKind, unit: Real) -> Real:
    """Z of sizes from 0 to 1, (n, sizes)."""
    low, high = kind.bounds.T
    z: Real = low + unit[:, : len(low)] * (high - low)
    return z


def _peak(kind: DamageKind, unit: Real, reading: PeakReading, passages: Passages, wheel: Wheel) -> float:
    scenario = passages.scenario
    radius = scenario.steps_per_revolution * scenario.step_length / (2 * math.pi)
    sizes = kind.values(_sizes_of(kind, unit[np.newaxis])[0])
    angle = unit[len(sizes)] * scenario.track.spacing / radius
    lateral = FARTHEST * LATERAL * unit[-1] if kind.lateral else 0.0
    block = passages.run([kind.make(wheel, sizes, angle, lateral)], speed=reading.speed, axle_load=reading.axle_load)
    return float(block.forces[:, WHEELS.index(wheel)].max())


def _features(kind: DamageKind, unit: Real) -> Real:
    """Coordinates of the interpolation: a bay ends where it begins."""
    place = 2 * math.pi * unit[:, len(kind.unknowns)]
    others = np.delete(unit, len(kind.unknowns), axis=1)
    features: Real = np.column_stack([others, ROUND * np.cos(place), ROUND * np.sin(place)])
    return features
