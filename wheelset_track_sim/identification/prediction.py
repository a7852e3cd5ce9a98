"""What follows from an identified damage: force, axle stress and fatigue at other speeds and loads, with intervals.

Each draw of the posterior, of all kinds that explain the data by their probabilities, passes once: at a place of the
bay of its own, in a lateral place of the observations, after hits in the turns before. So intervals hold the scatter by
the place on the bay, too.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import qmc

from ..errors import InputError
from ..fatigue.axle import AxleFatigue, TurningWheel
from ..fatigue.curve import Curve
from ..fatigue.static_stress import static_stress
from ..irregularities import Irregularity
from ..runtime.progress import Progress, unreported
from ..scenario import WHEELS, Scenario
from ..simulation.models import load_models
from ..simulation.passages import Passages
from ..simulation.simulator import Simulator
from .results import Identification, Interval

PASSAGES = 32
"""Draws that pass at each speed and load."""
EARLIER = 2
"""Turns with hits before the one that counts."""
BEFORE, AFTER = 0.35, 1.5
"""Track that counts before and behind the hit, m."""
RUNS = 6
"""Draws of which fatigue is counted."""
DISTANCE = 150.0
"""Distance of each of them, m."""


@dataclass(frozen=True)
class Prediction:
    """What follows at one speed and load."""

    speed: float
    """m/s"""
    axle_load: float
    """N"""
    force: Interval
    """Largest contact force of a hit, N."""
    nodes: Mapping[str, Interval]
    """Largest maximum principal stress of a hit, Pa, by stress node."""
    damage_ratio: Mapping[str, Interval] = field(default_factory=dict)
    """Fatigue damage of the turning axle over that without defect, elementary rule, by stress node."""
    damage_per_km: Mapping[str, Interval] = field(default_factory=dict)
    """The same as damage in a kilometre by the S-N curve."""


def predict(
    found: Identification,
    speeds: Sequence[float] = (),
    axle_loads: Sequence[float] = (),
    *,
    curve: Curve | None = None,
    passages: int = PASSAGES,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[Prediction, ...]:
    """Predict force, stress and, with an S-N curve, fatigue of an identified damage.

    Parameters
    ----------
    found
        What ``identify`` returned.
    speeds, axle_loads
        Speeds, m/s, and axle loads, N, in all combinations; those of the first observation if empty.
    curve
        S-N curve; None for no fatigue.
    passages
        Draws that pass at each speed and load.
    seed
        Of the draws.
    progress
        Called with stage and fraction.

    Raises
    ------
    InputError
        If the likeliest kind does not explain the data: nothing follows from it then.

    Examples
    --------
    >>> found = identify(PeakReading(force=102e3), load_scenario("undamaged"), ["none"])
    >>> faster, = predict(found, speeds=[50.0], passages=2)
    >>> 98e3 < faster.force.estimate < 103e3  # N, without damage
    True
    """
    if passages < 2:
        raise InputError(f"passages = {passages}: give at least 2")
    progress = progress or unreported
    scenario, wheel = found.scenario, WHEELS.index(found.wheel)
    circumference = scenario.steps_per_revolution * scenario.step_length
    radius, bay, dx = circumference / (2 * math.pi), scenario.track.spacing, scenario.step_length
    lead = EARLIER * circumference
    run = Passages(scenario, before=BEFORE, after=bay + lead + AFTER)
    chosen = _draws(found, passages, seed)
    pairs = [(v, q) for v in speeds or found.speeds[:1] for q in axle_loads or found.axle_loads[:1]]
    predictions = []
    for number, (speed, load) in enumerate(pairs):
        forces, stresses = [], []
        for defects, place in chosen:
            angle = ((place * bay - lead) % bay) / radius
            turned = [dataclasses.replace(each, angle=angle) for each in defects]  # type: ignore[type-var]
            block = run.run(turned, speed=speed, axle_load=load)
            hit = round((BEFORE + angle * radius + lead) / dx)
            part = slice(hit - round(BEFORE / dx), hit + round(AFTER / dx))
            forces.append(block.forces[part, wheel].max())
            stresses.append(block.max_principal[part].max(axis=0))
            progress(f"predict {len(pairs)} cases", (number + len(forces) / len(chosen)) / len(pairs))
        nodes = scenario.output.stress_nodes
        of_nodes = {name: Interval.of(each) for name, each in zip(nodes, np.array(stresses).T, strict=True)}
        fatigue = _fatigue(scenario, speed, load, [each for each, _ in chosen[:RUNS]], curve) if curve else {}
        predictions.append(Prediction(speed, load, Interval.of(np.array(forces)), of_nodes, **fatigue))
    return tuple(predictions)


def _draws(found: Identification, count: int, seed: int) -> list[tuple[tuple[Irregularity, ...], float]]:
    """Damage and place on the bay, 0 to 1, of draws of all kinds that explain the data."""
    fits = found.explaining
    shares = np.cumsum([each.probability for each in fits])
    drawn = []
    for kind, draw, lateral, place in qmc.Sobol(4, seed=seed).random(1 << (count - 1).bit_length())[:count]:
        fit = fits[min(int(np.searchsorted(shares, kind * shares[-1])), len(fits) - 1)]
        observation = int(lateral * fit.laterals.shape[1])
        drawn.append((fit.damage(found.wheel, int(draw * len(fit.laterals)), observation), float(place)))
    return drawn


def _fatigue(
    scenario: Scenario, speed: float, load: float, damages: Sequence[tuple[Irregularity, ...]], curve: Curve
) -> dict[str, dict[str, Interval]]:
    """Damage ratios and damage in a kilometre of some draws, by node."""
    models, ratios, absolute = None, [], []
    for defects in damages:
        what = dataclasses.replace(
            scenario,
            speed=speed,
            axle_load=load,
            settle_on="surfaces",
            irregularities=(*scenario.irregularities, *defects),
        )
        models = models or load_models(what)
        simulator = Simulator(what, models=models)
        static = static_stress(what, models.reduced, what.output.stress_nodes)
        count = AxleFatigue(static, TurningWheel.of(what), curve)
        while simulator.next_step * what.step_length < DISTANCE:
            count.push(simulator.advance(round(DISTANCE / what.step_length) - simulator.next_step))
        ratios.append([node.ratios[0] for node in count.nodes])
        absolute.append([node.damage_in(1000.0)[0] for node in count.nodes])
    names = static.nodes
    return {
        name: {node: Interval.of(each) for node, each in zip(names, np.array(values).T, strict=True)}
        for name, values in (("damage_ratio", ratios), ("damage_per_km", absolute))
    }
