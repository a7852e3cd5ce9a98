"""What takes longer than an answer, in slices between answers: peaks over places of the bay, damage of the axle.

Each function is a generator. It yields after some tens of milliseconds of work: what the page shows from then on, or
None. Whoever runs it may stop in between, and go on later.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..fatigue.axle import AxleFatigue, TurningWheel
from ..fatigue.curve import load_curve
from ..fatigue.static_stress import static_stress
from ..runtime.progress import Progress
from ..simulation.simulator import Simulator
from ..verdict.limit_set import load_limits
from .answers import Answer, Explorer

PLACES = 12
"""Places of the damage on the bay."""
DISTANCE = 500.0
"""Run for the damage of the axle, m: within 0.5 % of all combinations of wheel angle and sleeper."""
PER = 1e6
"""Distance for which damage is given, m."""
CHUNK = 2778
"""Steps simulated at once."""
CURVE = "assumed_body"
"""S-N curve."""


def scatter(explorer: Explorer, answer: Answer) -> Iterator[Mapping[str, Any] | None]:
    """Largest force and amplitude of the damaged wheel where the damage meets the rail at places all over the bay."""
    view = answer.view
    if view.kind in ("none", "polygon"):
        yield {"kind": "scatter", "words": "", "done": PLACES}
        return
    peaks, amplitudes = [], []
    limits = load_limits(view.limits)
    for number in range(PLACES):
        place = number / PLACES * answer.scenario.track.spacing
        found = explorer.answer(dataclasses.replace(view, place=place))
        peaks.append(float(found.block.forces[:, found.wheel].max()) / 1e3)
        amplitudes.append(float(found.amplitude.max()) / 1e6)
        words = (
            f"Over {number + 1} places on the bay: peak {min(peaks):.0f} to {max(peaks):.0f} kN, median "
            f"{np.median(peaks):.0f}; stress amplitude {min(amplitudes):.1f} to {max(amplitudes):.1f} MPa"
        )
        for limit in limits.force if limits and number + 1 == PLACES else ():
            above = sum(1e3 * peak > limit.above for peak in peaks)
            words += f"; above {limit.above / 1e3:.0f} kN at {above} of {PLACES} places"
        more = "" if number + 1 == PLACES else f", {PLACES - number - 1} to come"
        yield {"kind": "scatter", "words": f"{words}{more}.", "done": number + 1}


def fatigue(explorer: Explorer, answer: Answer, progress: Progress) -> Iterator[Mapping[str, Any] | None]:
    """Damage of the axle over a run, beside that of an undamaged one.

    ``progress`` is called while force tables are built; what it raises ends the generator, and another one begins anew.
    """
    scenario = explorer.base.scenario_of(answer.view)
    reduced, curve = explorer.models(scenario).reduced, load_curve(CURVE)
    static = static_stress(scenario, reduced, scenario.output.stress_nodes)
    count = AxleFatigue(static, TurningWheel.of(scenario), curve)
    run = Simulator(scenario, progress, explorer.tabled(scenario))
    yield None
    run.settle()
    steps = round(DISTANCE / scenario.step_length)
    while run.next_step < steps:
        yield None
        count.push(run.advance(min(CHUNK, steps - run.next_step)))
    ratios = [node.ratios[0] for node in count.nodes]
    worst = int(np.nanargmax(ratios)) if np.isfinite(ratios).any() else 0
    node = count.nodes[worst]
    (damage, *_), ratio = node.damage_in(PER), ratios[worst]
    times = f"{ratio:.2f} times that" if np.isfinite(ratio) else f"{damage:.2g}, and none"
    words = f"Damage of the axle per 1,000 km: {times} without damage, at {node.name}."
    source = (
        f"Damage of the axle: {damage:.2g} per 1,000 km by the elementary rule of Miner, from a run over "
        f"{DISTANCE:.0f} m, with the S-N curve {curve.name} ({curve.source})."
    )
    yield {"kind": "fatigue", "words": words, "source": source, "ratio": ratio if np.isfinite(ratio) else None}
