"""What takes longer than an answer, in slices between answers: peaks over places of the bay, damage of the axle.

Each function is a generator. It yields after some tens of milliseconds of work: what the page shows from then on, or
None. Whoever runs it may stop in between, and go on later.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from ..errors import InputError, WheelsetTrackError
from ..fatigue.axle import AxleFatigue, TurningWheel
from ..fatigue.curve import load_curve
from ..fatigue.static_stress import static_stress
from ..inputs.schema import unknown
from ..runtime.arrays import Real
from ..runtime.progress import Progress
from ..scenario import WHEELS
from ..simulation.simulator import Simulator
from ..twin.measured import Measurement, compare
from ..verdict.limit_set import load_limits
from .answers import Answer, Explorer
from .view import SLIDERS, View

PLACES = 12
"""Places of the damage on the bay."""
DISTANCE = 500.0
"""Run for the damage of the axle, m: within 0.5 % of all combinations of wheel angle and sleeper."""
PER = 1e6
"""Distance for which damage is given, m."""
CHUNK = 2778
"""Steps simulated at once."""
CELLS = 9
"""Values along each side of a map."""
QUANTITIES = {"force": "peak force (kN)", "stress": "bending amplitude (MPa)"}
"""What a map shows of the damaged wheel, and of the worst stress node."""
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
            f"{np.median(peaks):.0f}; bending amplitude {min(amplitudes):.1f} to {max(amplitudes):.1f} MPa"
        )
        for limit in limits.force if limits and number + 1 == PLACES else ():
            above = sum(1e3 * peak > limit.above for peak in peaks)
            words += f"; above {limit.above / 1e3:.0f} kN at {above} of {PLACES} places"
        more = "" if number + 1 == PLACES else f", {PLACES - number - 1} to come"
        yield {"kind": "scatter", "words": f"{words}{more}.", "done": number + 1}


def values_of(name: str) -> list[float]:
    """Values of a slider along a side of a map, over all its range, SI."""
    of = SLIDERS[name]
    shown = np.linspace(of.low, of.high, CELLS)
    return [of.read(name, f"{round(each / of.step) * of.step:.7g}") for each in shown]


def heat_map(explorer: Explorer, view: View, x: str, y: str, quantity: str) -> Iterator[Mapping[str, Any] | None]:
    """A result of a view over two of its sliders, cell by cell: every third value first, then those between.

    Raises InputError for names that are no sliders of the view. A cell without an answer stays empty.
    """
    for side, name in (("x", x), ("y", y)):
        if name not in SLIDERS or not view.applies(name):
            known = [each for each in SLIDERS if view.applies(each)]
            raise InputError(unknown("slider of this view", f"map {side} = {name!r}", name, known))
    if x == y:
        raise InputError(f"the map has {x} on both sides: give two sliders")
    if quantity not in QUANTITIES:
        raise InputError(unknown("quantity of maps", repr(quantity), quantity, [*QUANTITIES]))
    along, up = values_of(x), values_of(y)
    cells = sorted(np.ndindex(CELLS, CELLS), key=lambda cell: (cell[0] % 4 != 0 or cell[1] % 4 != 0, *cell))
    for done, (row, column) in enumerate(cells, 1):
        changes: dict[str, Any] = {x: along[column], y: up[row]}
        value: float | None = None
        with suppress(WheelsetTrackError):
            found = explorer.answer(dataclasses.replace(view, **changes))
            peak, amplitude = found.block.forces[:, found.wheel].max() / 1e3, found.amplitude.max() / 1e6
            value = float(peak if quantity == "force" else amplitude)
        yield {"kind": "map", "cell": [row, column], "value": value, "done": done, "of": len(cells)}


def beside(answer: Answer, measurement: Measurement, name: str) -> tuple[dict[str, Any], dict[str, Real]]:
    """What the page shows of a measurement: words, and the force of the damaged wheel where the answer is.

    Raises InputError if the measurement has no signal of the answer, or cannot be placed on it.
    """
    found = compare([answer.block], measurement)
    along = 1.0 if found.axis == "position" else answer.view.speed
    zero = answer.block.position if found.axis == "position" else answer.block.time
    words = [
        f"{each}: at most {of.max_measured / size:.4g} {unit} measured, {of.max_simulated / size:.4g} simulated, gain "
        f"{of.gain:.3f}, correlation {of.correlation:.3f}"
        for each, of in zip(found.names, found.agreement, strict=True)
        for unit, size in [("kN", 1e3) if each in WHEELS else ("MPa", 1e6)]
    ]
    arrays = {"place": answer.position[0] + along * (found.at - zero)}
    wheel = WHEELS[answer.wheel]
    if wheel in found.names:
        arrays["force"] = found.measured[:, found.names.index(wheel)] / 1e3
    else:
        arrays["force"] = np.full(len(found.at), np.nan)
    return {"kind": "measured", "words": f"{name}, beside the answer: {'; '.join(words)}."}, arrays


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
