"""Draw every shipped scenario with what it does to forces and stresses, and write docs/gallery.md: `make gallery`."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure

from wheelset_track_sim.report.figures import COLOURS
from wheelset_track_sim.report.pictures.scenario import PictureRow, description, rows_of, write_rows
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.agenda import step_of
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.supports import along

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "gallery.md"
PICTURES = ROOT / "docs" / "images" / "gallery"

GROUPS = {
    "Treads": (
        *("damage_wheel_1", "damage_wheel_2", "damage_both", "rcf_cluster", "flat_fresh", "flat_rounded", "polygon"),
        *("rough_wheel", "measured_tread", "growing_damage"),
    ),
    "Rails": ("rail_roughness", "corrugation", "squat", "insulated_joint", "dipped_weld"),
    "Profiles": ("worn_profiles", "lateral_offset"),
    "Track": ("hanging_sleeper", "stiffness_transition", "scattered_support", "slab_track"),
    "Wheelset, vehicle and loads": (
        *("trailer", "freight", "metro", "imported", "long_wave"),
        *("press_fit", "braking_torque"),
    ),
    "All together": ("mixed",),
}
WINDOW = 1.5
"""m shown to either side of the largest deviation from the static force..."""
WIDE = 12.0
"""...and where it is the supports that differ, or a vehicle that moves, or something happens on the way."""
LONGEST = 60.0
"""m run at most."""

INTRODUCTION = """# Gallery

Every shipped scenario: what `wheelset-track-sim show SCENARIO` draws of it (here only what differs from the paper's
wheelset on the paper's track), and contact forces and stresses where they deviate most. `make gallery` draws all of it
anew. [irregularities.md](reference/irregularities.md), [profiles.md](reference/profiles.md),
[tracks.md](reference/tracks.md) and [wheelsets.md](reference/wheelsets.md) have the keys, the
formulas and their sources.

    .venv/bin/wheelset-track-sim show flat_fresh
    .venv/bin/wheelset-track-sim run flat_fresh
"""


def main(names: list[str]) -> int:
    """Draw all scenarios, or some; write the page."""
    for name in names or [name for group in GROUPS.values() for name in group]:
        print(draw(name))
    PAGE.write_text(page(), encoding="utf-8")
    return 0


def draw(name: str) -> Path:
    """Picture of a scenario and of its run."""
    scenario = load_scenario(name)
    rows = [row for row in rows_of(scenario) if row.special]
    rows.append(response(scenario))
    return write_rows(PICTURES / f"{name}.png", name, description(scenario), rows)


def response(scenario: Scenario) -> PictureRow:
    """Contact forces and stresses around the place where a force deviates most from the static one."""
    simulator = Simulator(scenario)
    steps = round(min(length(scenario, simulator), LONGEST) / scenario.step_length)
    blocks = []
    while simulator.next_step < steps:
        blocks.append(simulator.advance(steps - simulator.next_step))
    forces = np.concatenate([block.forces for block in blocks])
    stresses = np.concatenate([block.max_principal for block in blocks])
    wide = simulator.models.track.line is not None or scenario.vehicle is not None or scenario.events
    reach = round((WIDE if wide else WINDOW) / scenario.step_length)
    centre = int(np.abs(forces - scenario.wheel_load).max(axis=1).argmax())
    part = slice(max(0, centre - reach), min(steps, centre + reach))
    position = np.arange(steps)[part] * scenario.step_length

    def curves(axes: Axes, values: np.ndarray, names: list[str], quantity: str) -> None:
        for column in reversed(range(values.shape[1])):
            axes.plot(position, values[part, column], color=COLOURS[column % len(COLOURS)], label=names[column], lw=0.9)
        axes.set_xlim(position[0], position[-1])
        axes.set_xlabel("position along the track (m)")
        axes.set_ylabel(quantity)
        handles, labels = axes.get_legend_handles_labels()
        above = {"loc": "lower left", "bbox_to_anchor": (0, 1), "borderaxespad": 0.2}
        axes.legend(handles[::-1], labels[::-1], ncols=6, frameon=False, fontsize=9, **above)

    def drawn(part: SubFigure) -> None:
        left, right = part.subplots(1, 2)
        curves(left, forces / 1e3, ["wheel 1", "wheel 2"], "contact force (kN)")
        curves(right, stresses / 1e6, list(blocks[0].nodes), "principal stress (MPa)")

    return PictureRow(2.6, drawn, special=True)


def length(scenario: Scenario, simulator: Simulator) -> float:
    """A turn of the wheel, or as far as there is something on the rails or under them, or something happens, m."""
    turn = simulator.steps_per_revolution * scenario.step_length
    ends = [turn, *(getattr(each, "end", 0.0) + WINDOW for each in scenario.irregularities)]
    for event in scenario.events:
        begun = step_of(event, scenario, simulator.course) * scenario.step_length
        ends.append(begun + (event.grow.over if event.grow else 0.0) + 2 * turn)
    track = simulator.models.track
    if track.line is not None:
        found = along(track.line)
        differs = (np.abs(found.ballast_stiffness - 1) > 1e-9) | np.isfinite(found.gap)
        ends.append((np.flatnonzero(differs.any(axis=1)).max(initial=0) + 3) * track.spacing)
    return max(ends)


def page() -> str:
    """Text of the page: the comment at the head of each scenario file, and its picture."""
    parts = [INTRODUCTION]
    for title, names in GROUPS.items():
        parts.append(f"## {title}\n")
        parts += [f"### `{name}`\n\n{comment(name)}\n\n![{name}](images/gallery/{name}.png)\n" for name in names]
    return "\n".join(parts)


def comment(name: str) -> str:
    """What a scenario file says at its head."""
    text = (ROOT / "config" / "scenarios" / f"{name}.yaml").read_text(encoding="utf-8")
    lines = re.match(r"(?:#.*\n)+", text)
    return "\n".join(line.removeprefix("#").strip() for line in lines[0].splitlines()) if lines else ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
