"""Draw the picture of ``docs/howto/identify.md``: a force with noise on a track that is not the model's, and its fit.

.venv/bin/python tools/identified_picture.py
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from wheelset_track_sim import Observation, Passages, identify, load_scenario
from wheelset_track_sim.irregularities import Flat
from wheelset_track_sim.report.identified import draw_identification

PICTURE = Path(__file__).parent.parent / "docs" / "images" / "identified_force.png"


def main() -> None:
    """Simulate, identify and draw."""
    scenario = load_scenario("undamaged", ["settle_on=smooth"])
    track = scenario.track
    stiffer = dataclasses.replace(track, pad=dataclasses.replace(track.pad, stiffness=1.1 * track.pad.stiffness))
    passages = Passages(dataclasses.replace(scenario, track=stiffer), before=0.8, after=1.8)
    block = passages.run([Flat("wheel_1", length=0.060, worn_length=0.100, angle=0.3)], speed=26.0)
    force = block.forces[::3, 0] + 2e3 * np.random.default_rng(1).standard_normal(len(block.forces[::3]))
    time = 3 * block.step_period * np.arange(len(force))
    data = Observation("force", time, force, source="passage.csv", speed=26.1)
    draw_identification(identify([data], scenario), PICTURE)


if __name__ == "__main__":
    main()
