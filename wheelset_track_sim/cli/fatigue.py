"""``fatigue``: cycles and damage of the turning axle, of scenarios that are simulated, of bags and of ledgers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rich.table import Table

from ..bags.bag import Bag
from ..errors import InputError, RecordingError, recorded_input, warn
from ..fatigue.axle import AxleFatigue, NodeFatigue, TurningWheel
from ..fatigue.curve import Curve, load_curve
from ..fatigue.findley import Findley, load_findley, node_usages
from ..fatigue.rainflow import GATE, StressSpectrum
from ..fatigue.scatter import ScatteredDamage
from ..fatigue.static_stress import check_loads, static_stress
from ..inputs import shipped
from ..inputs.amounts import in_unit
from ..inputs.yaml12 import parse
from ..runtime.arrays import Real
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..scenario import Scenario, load_scenario, scenario_from
from ..simulation.simulator import Simulator
from ..wheelset.kinds import reduce_wheelset
from ..wheelset.reduced import ReducedWheelset
from .booking import Book, Booking
from .console import print_object, terminal
from .fatigue_words import LABELS, PER, by_curve
from .progress import shown

DISTANCE = 500.0
"""Run by default, m: damage is within 0.5 % of that over all combinations of wheel angle and sleeper."""
LONGEST = 1e7
"""m"""
LONGEST_SERVICE = 1e11
"""m"""
CHUNK = 5556
"""Steps simulated at once."""


def fatigue(
    run: str,
    changes: Sequence[str],
    curve_name: str,
    distance: float | None,
    *,
    angles: int,
    gate: float | None,
    criterion_name: str | None,
    service: float | None,
    json: bool,
    warnings: Sequence[str] = (),
    mark: float = 0.0,
) -> int:
    """Count the cycles of a run and print its damage at each stress node; returns the exit status."""
    curve = load_curve(curve_name)
    criterion = load_findley(criterion_name) if criterion_name else None
    if service is not None and not 0 < service <= LONGEST_SERVICE:
        raise InputError(f"--service {service:g} m is out of range: give more than 0 m, up to {LONGEST_SERVICE:g} m")
    found, name = counted(run, changes, curve, distance, angles=angles, gate=gate, mark=mark)
    nodes, spectrum = found.nodes, found.spectrum
    further = []
    if curve.amplitude_scatter is not None or service is not None:
        further.append(_scatter(nodes, spectrum, curve, service))
    if criterion:
        further.append(_usage(run, changes, criterion, nodes))
    if json:
        result = as_mapping(name, nodes, spectrum, curve)
        for part in further:
            result |= part.about
            for node, values in part.values.items():
                result["nodes"][node] |= values
        print_object(result | {"warnings": [*warnings]})
    else:
        shown_as = table(name, nodes, curve)
        for part in further:
            for what, texts in part.rows.items():
                shown_as.add_row(what, *texts)
            shown_as.caption = f"{shown_as.caption}{part.note}"
        terminal().print(shown_as)
    return 0


@dataclasses.dataclass(frozen=True)
class Further:
    """Further results of the nodes: for JSON by node, rows of text by name, and what they depend on."""

    values: dict[str, dict[str, Any]]
    rows: dict[str, list[str]]
    about: dict[str, Any] = dataclasses.field(default_factory=dict)
    note: str = ""


def _scatter(nodes: Sequence[NodeFatigue], spectrum: StressSpectrum, curve: Curve, service: float | None) -> Further:
    """Damage as a band over the scatter of the curve, and the failure probability after a distance, m."""
    values: dict[str, dict[str, Any]] = {}
    rows: dict[str, list[str]] = {}
    per_node = len(spectrum.damage) // len(nodes)
    for index, node in enumerate(nodes):
        axle = ScatteredDamage(spectrum, index * per_node + node.worst, curve, node.distance)
        bands = {rule: axle.band(rule, PER)[::-1] for rule in curve.rules}
        values[node.name] = {"damage_per_1000_km_band": {rule: [*band] for rule, band in bands.items()}}
        for what, damage in zip(("strong", "weak"), bands["elementary"], strict=True):
            rows.setdefault(f"* elementary, {what} axle (2.5 %)", []).append(f"{damage:.3g}")
        if service is None:
            continue
        failing = {rule: axle.failure_probability(rule, service) for rule in curve.rules}
        values[node.name]["failure_probability"] = failing
        for rule, share in failing.items():
            rows.setdefault(f"* fail within {service / 1e3:,.0f} km, {LABELS[rule]}", []).append(f"{share:.2g}")
    return Further(values, rows, {} if service is None else {"service_m": service})


def _usage(run: str, changes: Sequence[str], criterion: Findley, nodes: Sequence[NodeFatigue]) -> Further:
    """Share of the fatigue limit by Findley's criterion around each node."""
    scenario = first_scenario(run, changes)
    if is_bag(run):
        reduced, blocks = reduce_wheelset(scenario.wheelset, vehicle=scenario.vehicle), iter(Bag(Path(run)).blocks())
    else:
        simulator = Simulator(scenario)
        simulator.settle()
        reduced, blocks = simulator.models.reduced, iter(lambda: simulator.advance(CHUNK), None)
    names = [node.name for node in nodes]
    usages = node_usages(criterion, scenario, reduced, blocks, names, points=len(nodes[0].angles))
    values = {each.name: {"findley_usage": each.usage, "findley_angle_rad": each.angle} for each in usages}
    rows = {"* usage of the limit, Findley": [f"{each.usage:.3f}" for each in usages]}
    about = {"criterion": dataclasses.asdict(criterion) | {"assumed": criterion.assumed}}
    return Further(values, rows, about, f"\n* usage by the {criterion.note}")


def counted(
    run: str,
    changes: Sequence[str],
    curve: Curve,
    distance: float | None,
    *,
    angles: int,
    gate: float | None,
    mark: float = 0.0,
    booking: Booking | None = None,
) -> tuple[AxleFatigue, str]:
    """Count the cycles of a scenario that is simulated, or of a bag; returns them with the scenario's name.

    Raises InputError for what cannot be counted or is less than a turn, and RecordingError for a bag with gaps.
    """
    if distance is not None and not 0 < distance <= LONGEST:
        raise InputError(f"--distance {distance:g} m is out of range: give more than 0 m, up to {LONGEST:g} m")
    bag = is_bag(run)
    if bag and changes:
        raise InputError("--set changes a scenario, and a bag is a run already: leave it out, or give a scenario")
    with shown() as progress:
        how = How(curve, angles, gate, mark, booking, progress)
        found, name = (
            _recorded(Path(run), distance, how)
            if bag
            else simulated(load_scenario(run, changes), distance or DISTANCE, how)
        )
    counted_distance = found.steps * found.wheel.step_length
    if counted_distance < found.wheel.circumference:
        raise InputError(
            f"{run} has {counted_distance:g} m, less than one turn of {found.wheel.circumference:.4g} m: give more"
        )
    return found, name


def first_scenario(run: str, changes: Sequence[str]) -> Scenario:
    """Scenario that is simulated, or the first one of a bag; raises RecordingError for a bag without any."""
    if not is_bag(run):
        return load_scenario(run, changes)
    states = Bag(Path(run)).states
    if not states:
        raise RecordingError(f"{run} holds no scenario, so its loads are unknown: record it with this package")
    return recorded_scenario(Path(run), states[0].scenario)


def is_bag(run: str) -> bool:
    """Whether a name is one of a bag, and not of a scenario."""
    path = Path(run)
    return run not in shipped.names("scenarios") and (path.suffix == ".mcap" or path.is_dir())


class How(NamedTuple):
    """How runs are counted."""

    curve: Curve
    angles: int
    gate: float | None
    mark: float
    booking: Booking | None
    progress: Progress

    def begin(self, scenario: Scenario, reduced: ReducedWheelset, nodes: Sequence[str]) -> AxleFatigue:
        """A count of a scenario."""
        static = static_stress(scenario, reduced, nodes)
        gate = GATE if self.gate is None else self.gate
        return AxleFatigue(static, TurningWheel.of(scenario), self.curve, points=self.angles, gate=gate, mark=self.mark)

    def push_to(self, found: AxleFatigue, name: str, first_step: int) -> Callable[[SampleBlock], None]:
        """Takes in blocks of a count, which goes on from its last checkpoint if it is kept."""
        return found.push if self.booking is None else Book(found, self.booking, name, first_step).push


def simulated(scenario: Scenario, distance: float, how: How) -> tuple[AxleFatigue, str]:
    """Fatigue of a scenario over a distance, and its name."""
    torques = [event.torque for event in scenario.events if event.torque is not None]
    check_loads(
        [scenario.loads, *(dataclasses.replace(scenario.loads, torque=each, torque_plan=()) for each in torques)]
    )
    _warn_of_loads([event.axle_load or scenario.axle_load for event in scenario.events], scenario.axle_load)
    simulator = Simulator(scenario, how.progress)
    found = how.begin(scenario, simulator.models.reduced, scenario.output.stress_nodes)
    push = how.push_to(found, scenario.name, 0)
    simulator.settle()
    steps = math.ceil(distance / scenario.step_length)
    while simulator.next_step < steps:
        push(simulator.advance(min(CHUNK, steps - simulator.next_step)))
        how.progress(f"simulate {scenario.name}", simulator.next_step / steps)
    return found, scenario.name


def _recorded(path: Path, distance: float | None, how: How) -> tuple[AxleFatigue, str]:
    """Fatigue of a bag, and the name of its scenario; raises RecordingError for gaps and decimated samples."""
    bag = Bag(path)
    scenarios = [recorded_scenario(path, text) for text in dict.fromkeys(state.scenario for state in bag.states)]
    if not scenarios:
        raise RecordingError(f"{path} holds no scenario, so its loads are unknown: record it with this package")
    check_loads([each.loads for each in scenarios])
    scenario = scenarios[0]
    _warn_of_loads([state.axle_load for state in bag.states], scenario.axle_load)
    reduced = reduce_wheelset(scenario.wheelset, how.progress, scenario.vehicle)
    found: AxleFatigue | None = None
    end: float = math.inf
    for block in bag.blocks():
        if found is None:
            found = how.begin(scenario, reduced, block.nodes)
            push = how.push_to(found, bag.info.scenario_name, block.first_step)
            end = math.inf if distance is None else block.first_step + math.ceil(distance / scenario.step_length)
        left = end - block.first_step
        push(block if len(block) <= left else block.part(0, int(left)))
        if len(block) >= left:
            break
    assert found is not None  # a bag without blocks raises
    return found, bag.info.scenario_name


def _warn_of_loads(loads: Sequence[float], first: float) -> None:
    if any(load != first for load in loads):
        warn(
            f"axle_load changes during the run: ratios compare with an undamaged axle under {in_unit(first, 'kN', 'N')}"
        )


def recorded_scenario(path: Path, text: str) -> Scenario:
    """Scenario of a state; raises RecordingError."""
    try:
        with recorded_input():
            return scenario_from(parse(text, "scenario of the bag", trusted=False))
    except InputError as reason:
        raise RecordingError(f"{path} holds a scenario that cannot be used: {reason}") from None


def as_mapping(name: str, nodes: Sequence[NodeFatigue], spectrum: StressSpectrum, curve: Curve) -> dict[str, Any]:
    """The object that ``fatigue --json`` prints."""
    per_node = len(spectrum.damage) // len(nodes)
    merged = spectrum.merged_at_most[:, 0].reshape(len(nodes), per_node)
    return {
        "run": name,
        "distance_m": nodes[0].distance,
        "curve": dataclasses.asdict(curve) | {"assumed": curve.assumed},
        "angles_rad": nodes[0].angles.tolist(),
        "forced_half_cycles": int(spectrum.forced.sum()),
        "nodes": {
            node.name: {
                "ratio_to_undamaged": dict(zip(curve.rules, map(_or_none, node.ratios), strict=True)),
                "rotating_amplitude_Pa": node.amplitude,
                "undamaged_amplitude_Pa": node.undamaged_amplitude,
                "mean_Pa": node.mean,
                "equivalent_range_Pa": node.equivalent_range,
                "worst_angle_rad": node.angle,
                "damage_per_1000_km": dict(zip(curve.rules, node.damage_in(PER), strict=True)),
                "undamaged_damage_per_1000_km": _by_rule(node.undamaged * (PER / node.distance), curve),
                "damage_by_angle_per_1000_km": (node.damage[:, 0] * (PER / node.distance)).tolist(),
                "merged_damage_at_most": float(merged[index].max()),
            }
            for index, node in enumerate(nodes)
        },
    }


def _or_none(ratio: float) -> float | None:
    return None if math.isnan(ratio) else ratio


def _by_rule(damage: Real, curve: Curve) -> dict[str, float]:
    return dict(zip(curve.rules, damage.tolist(), strict=True))


def table(name: str, nodes: Sequence[NodeFatigue], curve: Curve) -> Table:
    """The same for people; a star marks what depends on the constants of the curve."""
    shown_as = Table(
        title=f"{name}: {nodes[0].distance:.0f} m, rotating stress at {len(nodes[0].angles)} angles",
        title_justify="left",
        caption=by_curve(curve),
        caption_justify="left",
    )
    shown_as.add_column("")
    for node in nodes:
        shown_as.add_column(node.name, justify="right")
    rows: list[tuple[str, Callable[[NodeFatigue], str]]] = [
        ("* damage, ratio to undamaged", lambda node: f"{node.ratios[0]:.2f}"),
        ("rotating amplitude", lambda node: f"{node.amplitude / 1e6:.1f} MPa"),
        ("rotating amplitude, undamaged", lambda node: f"{node.undamaged_amplitude / 1e6:.1f} MPa"),
        ("mean stress", lambda node: f"{node.mean / 1e6:.1f} MPa"),
        ("* equivalent range", lambda node: f"{node.equivalent_range / 1e6:.1f} MPa"),
        ("worst angle", lambda node: f"{math.degrees(node.angle):.0f} deg"),
    ]
    for what, of in rows:
        shown_as.add_row(what, *(of(node) for node in nodes))
    for rule, *damages in zip(curve.rules, *(node.damage_in(PER) for node in nodes), strict=True):
        shown_as.add_row(f"* damage per 1,000 km, {LABELS[rule]}", *(f"{damage:.3g}" for damage in damages))
    return shown_as
