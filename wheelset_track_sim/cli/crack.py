"""``crack``: how far an axle with a crack can run under the cycles of a scenario or a bag."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.table import Table

from ..errors import InputError
from ..fatigue.axle import AxleFatigue
from ..fatigue.crack import CrackLife, CrackSpectrum, crack_life, fastest
from ..fatigue.curve import load_curve
from ..fatigue.growth import ENDS, CrackGrowth, load_crack_growth
from ..inputs.amounts import in_unit
from ..wheelset.kinds import reduce_wheelset
from .console import print_object, terminal
from .fatigue import counted, first_scenario

ANY_CURVE = "assumed_body"
"""Cycles are counted with the damage of a curve, which does not matter here."""
MOST_INSPECTIONS = 100
SHOWN = 20
"""Points of a curve of depth over distance in JSON."""


@dataclass(frozen=True, eq=False)
class CrackedNode:
    """A crack at the angle of a stress node where it grows fastest."""

    name: str
    angle: float
    """rad."""
    diameter: float
    """Of the axle, m."""
    lives: Mapping[str, CrackLife]
    """By end of the band: ``slow``, ``middle``, ``fast``."""


def crack(
    run: str,
    changes: Sequence[str],
    growth_name: str,
    depth: float,
    distance: float | None,
    *,
    angles: int,
    inspections: int,
    json: bool,
    warnings: Sequence[str] = (),
) -> int:
    """Count the cycles of a run, grow a crack at each stress node and print what is left; returns the exit status."""
    growth = load_crack_growth(growth_name)
    if not 1 <= inspections <= MOST_INSPECTIONS:
        raise InputError(f"--inspections {inspections} is out of range: give 1 to {MOST_INSPECTIONS}")
    scenario = first_scenario(run, changes)
    axle = getattr(scenario.wheelset, "axle", None)
    if getattr(axle, "bore", 0.0):
        raise InputError("the axle is bored, and the stress intensity of a crack is known for solid axles only")
    found, name = counted(run, changes, load_curve(ANY_CURVE), distance, angles=angles, gate=None)
    reduced = reduce_wheelset(scenario.wheelset, vehicle=scenario.vehicle)
    diameters = [2 * math.hypot(*reduced.node_positions[reduced.node(node)][[0, 2]]) for node in found.static.nodes]
    nodes = [_cracked(found, index, growth, depth, diameter) for index, diameter in enumerate(diameters)]
    if json:
        print_object(as_mapping(name, found, nodes, growth, inspections) | {"warnings": [*warnings]})
    else:
        terminal().print(table(name, nodes, growth, depth, inspections))
    return 0


def _cracked(found: AxleFatigue, node: int, growth: CrackGrowth, depth: float, diameter: float) -> CrackedNode:
    points, length = len(found.angles), found.steps * found.wheel.step_length
    spectrum = found.spectrum
    spectra = [CrackSpectrum.of(spectrum, node * points + point, length) for point in range(points)]
    worst = fastest(spectra, growth.at("fast"), depth, diameter)
    lives = {end: crack_life(spectra[worst], growth.at(end), depth, diameter) for end in ENDS}
    return CrackedNode(found.static.nodes[node], float(found.angles[worst]), diameter, lives)


def as_mapping(
    name: str, found: AxleFatigue, nodes: Sequence[CrackedNode], growth: CrackGrowth, inspections: int
) -> dict[str, Any]:
    """The object that ``crack --json`` prints."""
    return {
        "run": name,
        "distance_m": found.steps * found.wheel.step_length,
        "growth": dataclasses.asdict(growth) | {"assumed": growth.assumed},
        "inspections": inspections,
        "nodes": {
            node.name: {
                "worst_angle_rad": node.angle,
                "diameter_m": node.diameter,
                "left_m": {end: _finite(life.left) for end, life in node.lives.items()},
                "inspection_interval_m": _finite(node.lives["fast"].left / inspections),
                "critical_depth_m": {end: float(life.depth[-1]) for end, life in node.lives.items()},
                "fractures": {end: life.fractures for end, life in node.lives.items()},
                "growth": {end: _curve(life) for end, life in node.lives.items()},
            }
            for node in nodes
        },
    }


def _finite(distance: float) -> float | None:
    """A distance; None if nothing grows."""
    return distance if math.isfinite(distance) else None


def _curve(life: CrackLife) -> dict[str, list[float | None]]:
    places = np.unique(np.linspace(0, len(life.depth) - 1, SHOWN).round().astype(int))
    return {
        "depth_m": life.depth[places].tolist(),
        "distance_m": [_finite(float(each)) for each in life.distance[places]],
    }


def table(name: str, nodes: Sequence[CrackedNode], growth: CrackGrowth, depth: float, inspections: int) -> Table:
    """The same for people; a star marks what depends on the law of growth."""
    shown_as = Table(
        title=f"{name}: a crack of {in_unit(depth, 'mm', 'm')} at its worst angle",
        title_justify="left",
        caption=f"* by the {growth.note}",
        caption_justify="left",
    )
    shown_as.add_column("")
    for node in nodes:
        shown_as.add_column(node.name, justify="right")
    for end in ENDS:
        shown_as.add_row(f"* distance left, {end}", *(_kilometres(node.lives[end].left) for node in nodes))
    rows: list[tuple[str, Callable[[CrackedNode], str]]] = [
        (f"* inspect every (fast / {inspections})", lambda node: _kilometres(node.lives["fast"].left / inspections)),
        ("* critical depth, fast", lambda node: f"{1e3 * node.lives['fast'].depth[-1]:.0f} mm"),
        ("worst angle", lambda node: f"{math.degrees(node.angle):.0f} deg"),
        ("diameter of the axle", lambda node: f"{1e3 * node.diameter:.0f} mm"),
    ]
    for what, of in rows:
        shown_as.add_row(what, *(of(node) for node in nodes))
    return shown_as


def _kilometres(distance: float) -> str:
    if not math.isfinite(distance):
        return "no growth"
    return f"{distance / 1e3:,.0f} km" if distance >= 1e5 else f"{distance / 1e3:.3g} km"
