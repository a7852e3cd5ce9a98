"""``fatigue --mission``: damage of an axle over a service of speeds, loads and growing damage."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

from rich.table import Table

from ..errors import InputError
from ..fatigue.axle import NodeFatigue
from ..fatigue.curve import Curve, load_curve
from ..fatigue.mission import Mission, MissionNode, load_mission, mission_damage
from ..scenario import load_scenario
from .console import print_object, terminal
from .fatigue import How, simulated
from .fatigue_words import LABELS, PER, by_curve
from .progress import shown

LONGEST = 1e10
"""m"""


def fatigue_of_mission(
    run: str,
    changes: Sequence[str],
    curve_name: str,
    distance: float | None,
    mission_name: str,
    *,
    angles: int,
    gate: float | None,
    json: bool,
    warnings: Sequence[str] = (),
) -> int:
    """Run the legs of a mission at each stage, and print what they add up to; returns the exit status.

    Without a distance it ends where the last stage begins, or after 1,000 km.
    """
    curve, mission = load_curve(curve_name), load_mission(mission_name)
    if distance is not None and not 0 < distance <= LONGEST:
        raise InputError(f"--distance {distance:g} m is out of range: give more than 0 m, up to {LONGEST:g} m")
    base = load_scenario(run, changes)
    over = distance or mission.growth[-1].after or PER
    scenarios = mission.scenarios(base)
    found: list[list[tuple[NodeFatigue, ...]]] = []
    with shown() as progress:
        how = How(curve, angles, gate, 0.0, None, progress)
        for length, legs in zip(mission.lengths(over), scenarios, strict=True):
            if length > 0:
                found.append([simulated(each, mission.sample, how)[0].nodes for each in legs])
    driven = dataclasses.replace(mission, growth=mission.growth[: len(found)])
    nodes = mission_damage(driven, found)
    result = mission_mapping(base.name, driven, nodes, curve, over)
    result |= {"curve": dataclasses.asdict(curve) | {"assumed": curve.assumed}, "warnings": [*warnings]}
    print_object(result) if json else terminal().print(mission_table(base.name, driven, nodes, curve, over))
    return 0


def mission_mapping(
    name: str, mission: Mission, nodes: Sequence[MissionNode], curve: Curve, distance: float
) -> dict[str, Any]:
    """The object that ``fatigue --mission --json`` prints."""
    ends = [*(stage.after for stage in mission.growth[1:] if stage.after < distance), distance]
    return {
        "run": name,
        "mission": mission.title,
        "distance_m": distance,
        "angles_rad": nodes[0].angles.tolist(),
        "nodes": {
            node.name: {
                "ratio_to_undamaged": _ratio(node, distance),
                "rotating_amplitude_Pa": node.amplitude,
                "worst_angle_rad": float(node.angles[node.worst(distance)]),
                "damage": dict(zip(curve.rules, node.damage(distance)[node.worst(distance)].tolist(), strict=True)),
                "undamaged_damage": dict(zip(curve.rules, node.undamaged(distance).tolist(), strict=True)),
                "distance_to_damage_1_m": {
                    rule: None if math.isinf(life) else life
                    for rule, life in zip(curve.rules, node.life().tolist(), strict=True)
                },
                "share_of_legs": node.leg_shares(distance).tolist(),
                "damage_over_distance": [[end, float(node.damage(end)[:, 0].max())] for end in ends],
                "damage_by_angle": node.damage(distance)[:, 0].tolist(),
            }
            for node in nodes
        },
    }


def mission_table(name: str, mission: Mission, nodes: Sequence[MissionNode], curve: Curve, distance: float) -> Table:
    """The same for people; a star marks what depends on the constants of the curve."""
    shown = Table(
        title=f"{mission.title}: {name} over {distance / 1e3:,.0f} km",
        title_justify="left",
        caption=f"{by_curve(curve)}\nbeyond the last stage its damage rate holds",
        caption_justify="left",
    )
    shown.add_column("")
    for node in nodes:
        shown.add_column(node.name, justify="right")
    rows: list[tuple[str, Callable[[MissionNode], str]]] = [
        ("* damage, ratio to undamaged", lambda node: f"{_ratio(node, distance):.2f}"),
        ("largest rotating amplitude", lambda node: f"{node.amplitude / 1e6:.1f} MPa"),
        ("worst angle", lambda node: f"{math.degrees(node.angles[node.worst(distance)]):.0f} deg"),
        *(
            (f"* damage, {LABELS[rule]}", lambda node, at=at: f"{node.damage(distance)[node.worst(distance), at]:.3g}")
            for at, rule in enumerate(curve.rules)
        ),
        *(
            (f"* distance to damage 1, {LABELS[rule]}", lambda node, at=at: _km(float(node.life()[at])))
            for at, rule in enumerate(curve.rules)
        ),
        *(
            (
                f"* share of {leg.name or f'leg {at + 1}'} ({100 * leg.share:.3g} % of the way)",
                lambda node, at=at: f"{100 * node.leg_shares(distance)[at]:.0f} %",
            )
            for at, leg in enumerate(mission.legs)
        ),
    ]
    for what, of in rows:
        shown.add_row(what, *(of(node) for node in nodes))
    return shown


def _ratio(node: MissionNode, distance: float) -> float:
    return float(node.damage(distance)[:, 0].max() / node.undamaged(distance)[0])


def _km(distance: float) -> str:
    return "none" if math.isinf(distance) else f"{float(f'{distance / 1e3:.3g}'):,.0f} km"
