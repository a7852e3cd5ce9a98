"""A damage is found again from a force with noise and errors; ``benchmarks.identification`` has many cases."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim import Observation, Passages, identify, load_scenario, predict
from wheelset_track_sim.irregularities import Flat

LENGTH, RATIO = 0.050, 1.6


@pytest.mark.slow
def test_a_worn_flat_is_told_from_a_fresh_one_and_predicted_at_another_speed():
    scenario = load_scenario("undamaged", ["settle_on=smooth"])
    passages = Passages(scenario, before=0.8, after=2.3)
    worn = Flat("wheel_1", length=LENGTH, worn_length=RATIO * LENGTH, angle=0.35 / scenario.wheelset.rolling_radius)
    block = passages.run([worn], speed=26.0)
    noise = 2e3 * np.random.default_rng(1).standard_normal(len(block.forces[::3]))
    force = 1.02 * block.forces[::3, 0] + noise
    time = 3 * block.step_period * np.arange(len(force))
    data = Observation("force", time, force, speed=26.1)
    found = identify([data], scenario, ["flat", "worn_flat", "none"], track_error=0.0)
    best = found.best
    assert (best.kind, best.explains) == ("worn_flat", True)
    assert best.probability > 0.99
    assert best.parameters["fresh_length_m"].estimate == pytest.approx(LENGTH, rel=0.02)
    assert best.parameters["worn_ratio"].estimate == pytest.approx(RATIO, rel=0.05)
    assert not found.kinds[-1].explains
    (then,) = predict(found, [20.0], passages=4)
    true = passages.run([dataclasses.replace(worn, angle=0.0)], speed=20.0).forces[:, 0].max()
    assert then.force.estimate == pytest.approx(true, rel=0.1)
