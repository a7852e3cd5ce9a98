"""Draw the pictures of the pages on fatigue and cracks in ``docs/howto``.

    .venv/bin/python tools/fatigue_pictures.py

The first is the figure of the study ``fatigue_speed``, whose runs are kept in ``results``; it takes some minutes.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from wheelset_track_sim import Simulator, load_scenario, load_study, run_study
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.crack import CrackSpectrum, crack_life, fastest
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.growth import load_crack_growth
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.report.figures import COLOURS, new_figure

ROOT = Path(__file__).parent.parent
IMAGES = ROOT / "docs" / "images"
RUN = 100.0
"""Distance whose cycles are repeated, m."""
DEPTH, DIAMETER = 0.002, 0.181
"""Of the crack at the beginning, and of the axle at A1, m."""
CASES = {"undamaged": "round wheels", "damage_wheel_1": "breakout, 2 mm deep", "flat_rounded": "rounded flat"}


def speed() -> Path:
    """Damage over speed, by its study."""
    folder = ROOT / "results" / "fatigue_speed-causal"
    results = run_study(load_study("fatigue_speed"), folder)
    for drawing in results.study.drawings:
        drawing.draw(results, folder)
    return Path(shutil.copy(folder / "fatigue.png", IMAGES / "fatigue_speed.png"))


def spectra(name: str) -> list[CrackSpectrum]:
    """Cycles around A1 of a shipped scenario."""
    scenario = load_scenario(name)
    simulator = Simulator(scenario)
    static = static_stress(scenario, simulator.models.reduced, ["A1"])
    fatigue = AxleFatigue(static, TurningWheel.of(scenario), load_curve("assumed_body"))
    while fatigue.steps < RUN / scenario.step_length:
        fatigue.push(simulator.advance(round(RUN / scenario.step_length) - fatigue.steps))
    return [CrackSpectrum.of(fatigue.spectrum, point, RUN) for point in range(len(fatigue.angles))]


def crack() -> Path:
    """Depth of a crack over distance."""
    growth = load_crack_growth("assumed_steel")
    note = f"Node A1 of x40 on ballasted_60e1, 100 km/h, 20 t; a crack of 2 mm at its worst angle. By the {growth.note}"
    with new_figure(4.4, "Depth of a crack over the distance", note) as figure:
        axes = figure.subplots()
        for colour, (name, label) in zip(COLOURS, CASES.items(), strict=False):
            around = spectra(name)
            cycles = around[fastest(around, growth.at("fast"), DEPTH, DIAMETER)]
            for end, dashes in (("fast", "-"), ("middle", (0, (4, 2)))):
                life = crack_life(cycles, growth.at(end), DEPTH, DIAMETER)
                grown = np.isfinite(life.distance)
                style = {"color": colour, "linestyle": dashes, "label": f"{label}, {end}"}
                axes.plot(life.distance[grown] / 1e6, 1e3 * life.depth[grown], **style)
        axes.set_xscale("log")
        axes.set_xlim(0.1, 50)
        axes.set_ylim(0, 95)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.set_xlabel("distance (1,000 km)")
        axes.set_ylabel("depth of the crack (mm)")
        axes.grid(color="#e8e8ea", linewidth=0.6)
        axes.legend(frameon=False, fontsize=9, loc="upper left")
        figure.savefig(IMAGES / "crack_growth.png")
    return IMAGES / "crack_growth.png"


if __name__ == "__main__":
    for draw in (crack, speed):
        print(draw())
