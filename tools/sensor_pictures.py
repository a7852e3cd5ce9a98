"""Draw the pictures of the pages on sensors in ``docs/howto``.

    .venv/bin/python tools/sensor_pictures.py

Each picture is made from one run, which the page describes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from wheelset_track_sim import Simulator, load_scenario
from wheelset_track_sim.samples.spectra import density, reference_of, third_octaves
from wheelset_track_sim.scenario import Scenario, scenario_from
from wheelset_track_sim.sensors.reading import SensorReaders

IMAGES = Path(__file__).parent.parent / "docs" / "images"
G = 9.81
BOXES: dict[str, Any] = {
    "type": "axle_box_acceleration",
    "rate": 10e3,
    "range": 500.0,
    "noise": 0.5,
    "true_value": True,
}
GAUGES: list[dict[str, Any]] = [
    {"type": "strain_gauge", "name": "turning", "y": 0.05, "rate": 2000.0},
    {"type": "strain_gauge", "name": "fixed", "y": 0.05, "turning": False, "rate": 2000.0},
]
COLOURS = ("#e0641f", "#3b8ed0", "#1f9e77")


def with_sensors(name: str, *sensors: dict[str, Any]) -> Scenario:
    """A shipped scenario with sensors."""
    return scenario_from({**load_scenario(name).to_mapping(), "sensors": [*sensors]})


def run(scenario: Scenario, duration: float) -> dict[str, dict[str, Any]]:
    """Time and channels of each sensor, by topic."""
    simulator = Simulator(scenario)
    readers = SensorReaders(scenario.sensors, simulator.steps_per_revolution, simulator.models.tread_origin)
    chunks = readers.push(simulator.advance(round(duration / scenario.step_period))) + readers.finish()
    found: dict[str, dict[str, Any]] = {}
    for chunk in chunks:
        of = found.setdefault(chunk.topic, {"time": []} | {name: [] for name in chunk.values})
        of["time"].append(chunk.time + chunk.step_period * np.arange(len(chunk)))
        for name, values in chunk.values.items():
            of[name].append(values)
    return {topic: {name: np.concatenate(parts) for name, parts in of.items()} for topic, of in found.items()}


def axle_boxes() -> Figure:
    """Acceleration of the box at an impact, and third octaves of a sound and a damaged wheel."""
    damaged, sound = (run(with_sensors(name, BOXES), 3.0) for name in ("damage_wheel_1", "undamaged"))
    figure = Figure((8.0, 5.6), layout="constrained")
    over_time, bands = figure.subplots(2)
    true, read = damaged["axle_box_acceleration/true"], damaged["axle_box_acceleration"]
    at = true["time"][np.abs(true["wheel_1"][true["time"] < 1.0]).argmax()]
    for of, label, style in ((true, "true value", "-"), (read, "sensor: 10 kHz, range 500 m/s²", ".-")):
        near = (of["time"] > at - 0.004) & (of["time"] < at + 0.02)
        over_time.plot(1e3 * (of["time"][near] - at), of["wheel_1"][near] / G, style, lw=1.0, ms=3, label=label)
    over_time.set(xlabel="time from the largest acceleration, ms", ylabel="acceleration of axle box 1, g")
    over_time.legend(loc="upper right")
    for of, label, colour in ((damaged, "breakout, 2 mm deep", COLOURS[0]), (sound, "undamaged", COLOURS[1])):
        found = third_octaves(density(of["axle_box_acceleration"]["wheel_1"], BOXES["rate"]))
        bands.step(found.middle, found.levels(reference_of("m/s^2")), where="mid", color=colour, label=label)
    bands.set(xscale="log", xlabel="one-third-octave band, Hz", ylabel="level, dB re 1e-6 m/s²")
    bands.legend(loc="upper left")
    for axes in (over_time, bands):
        axes.grid(alpha=0.3)
    return figure


def gauges() -> Figure:
    """Strain of a gauge that turns and of one that is fixed, over a few turns with an impact each."""
    found = run(with_sensors("damage_wheel_1", *GAUGES), 0.5)
    figure = Figure((8.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for name, colour in (("turning", COLOURS[0]), ("fixed", COLOURS[1])):
        of = found[f"strain/{name}"]
        axes.plot(of["time"], 1e6 * of["strain"], color=colour, lw=1.0, label=f"{name}")
    axes.set(xlabel="simulated time, s", ylabel="strain, 1e-6", ylim=(-300, 350))
    axes.legend(loc="upper right", ncols=2)
    axes.grid(alpha=0.3)
    return figure


def main() -> None:
    """Draw all."""
    mpl.rcParams.update({"font.size": 9.0, "axes.prop_cycle": mpl.cycler(color=COLOURS)})
    for name, draw in (("axle_box_acceleration", axle_boxes), ("turning_strain_gauge", gauges)):
        draw().savefig(IMAGES / f"{name}.png", dpi=130)


if __name__ == "__main__":
    main()
