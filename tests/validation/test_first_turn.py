"""A run is right from its first step: its first turn is that of a run that has been on these surfaces for a while.

Two runs of one scenario meet at the same place of the bay, of the rails and of the wheel: one begins there, the other
began 1.5 s before. Nothing is left out at the beginning of the first one.
"""

import numpy as np
import pytest

from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.simulation.speed import Stretch

STATIC = 98.1e3  # N
KINDS = {
    "breakout": "{type: breakout, on: wheel_1, a: 0.03, b: 0.024, h: 0.002}",
    "cluster": "{type: cluster, on: wheel_1, number: 20, a: 0.01, b: 0.008, h: 0.0005}",
    "flat": "{type: flat, on: wheel_1, length: 0.05}",
    "polygon": "{type: polygon, on: wheel_1, harmonics: [{order: 24, amplitude: 1.0e-4}]}",
    "roughness": "{type: roughness, on: wheel_1, seed: 1, level: 6.0}",
    "profile": "{type: profile, on: wheel_1, file: synthetic_tread.csv, gaps: fill}",
    "roughness of a rail": "{type: roughness, on: rail_1, seed: 2}",
    "corrugation": "{type: corrugation, on: rail_1, wavelength: 0.06, amplitude: 2.0e-5}",
    "squat": "{type: squat, on: rail_1, position: 42.3, a: 0.02, b: 0.015, h: 0.0005}",
    "head_defect": "{type: head_defect, on: rail_2, position: 42.3, a: 0.02, b: 0.015, h: 0.0005}",
    "joint": "{type: joint, on: rail_1, position: 42.3, dip_angle: 0.01}",
    "dipped_weld": "{type: dipped_weld, on: rail_1, position: 42.3, length: 1.0, depth: 0.0005}",
}


@pytest.fixture(scope="module")
def models():
    return load_models(load_scenario("undamaged"))


def turn_from(scenario, models, begin, first):
    """Forces and maximum principal stresses of the turn from ``first`` on, of a run that begins at step ``begin``."""
    start = Stretch(begin, begin * scenario.step_period, scenario.speed, scenario.speed)
    simulator = Simulator(scenario, models=models, start=start)
    while simulator.next_step < first:
        simulator.advance(first - simulator.next_step)
    blocks = []
    while simulator.next_step < first + scenario.steps_per_revolution:
        blocks.append(simulator.advance(first + scenario.steps_per_revolution - simulator.next_step))
    return [np.concatenate([getattr(block, name) for block in blocks]) for name in ("forces", "max_principal")]


@pytest.mark.slow
@pytest.mark.parametrize("speed", [15.0, 27.7777778, 55.0])
@pytest.mark.parametrize("kind", KINDS)
def test_the_first_turn_is_that_of_a_run_that_began_earlier(models, kind, speed):
    scenario = load_scenario("undamaged", [f"speed={speed}", f"irregularities=[{KINDS[kind]}]"])
    there = round(1.5 * speed / 0.6) * 600
    forces, stress = turn_from(scenario, models, there, there)
    settled, settled_stress = turn_from(scenario, models, 0, there)
    assert np.abs(forces - settled).max() < 3e-3 * STATIC
    np.testing.assert_allclose(forces.max(axis=0), settled.max(axis=0), atol=2e-3 * STATIC)
    np.testing.assert_allclose(forces.min(axis=0), settled.min(axis=0), atol=2e-3 * STATIC)
    # At 55 m/s the fourth multiple of the turns is next to a bending mode that rings for seconds.
    np.testing.assert_allclose(stress.max(axis=0), settled_stress.max(axis=0), rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "most", "least"), [(27.7777778, 164.8e3, 51.3e3), pytest.param(55.0, 208.7e3, 20.3e3)]
)
def test_a_measured_tread_has_the_peaks_of_running_on_it(speed, most, least):
    """As an audit found them with the surface present before; a start on smooth treads gave 140.8 and 146.2 kN."""
    simulator = Simulator(load_scenario("measured_tread", [f"speed={speed}"]))
    force = simulator.advance(simulator.steps_per_revolution).forces[:, 0]
    assert force.max() == pytest.approx(most, rel=0.01)
    assert force.min() == pytest.approx(least, abs=0.02 * STATIC)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("{type: polygon, on: wheel_1, harmonics: [{order: 24, amplitude: 1.0e-4}]}",
         "{type: polygon, on: wheel_1, harmonics: [{order: 24, amplitude: 1.0e-4, phase: 0.6}]}"),
        (KINDS["roughness"], KINDS["roughness"].replace("seed: 1", "seed: 3")),
        (KINDS["profile"], KINDS["polygon"]),
        (KINDS["roughness of a rail"], KINDS["corrugation"]),
    ],
    ids=["phase", "seed", "kind", "rail"],
)  # fmt: skip
def test_a_live_change_adds_nothing_of_its_own(models, before, after):
    """Within the fade, forces stay in the envelope of both surfaces; after it they are those of the new ones."""
    speed = 55.0
    old, new = (load_scenario("undamaged", [f"speed={speed}", f"irregularities=[{each}]"]) for each in (before, after))
    simulator = Simulator(old, models=models)
    simulator.advance(5000)
    revision = simulator.apply(new)
    begin, end = revision.step, revision.step + round(0.3 * speed / 1e-3)
    forces = simulator.advance(begin + 1 - simulator.next_step).forces if begin >= simulator.next_step else None
    found = [] if forces is None else [forces]
    while simulator.next_step < end + 4 * 2713:
        found.append(simulator.advance(end + 4 * 2713 - simulator.next_step).forces)
    force = np.concatenate(found)
    of = []
    for scenario in (old, new):  # as they run by themselves, over the same steps
        alone = Simulator(scenario, models=models)
        run = []
        while alone.next_step < end + 4 * 2713:
            run.append(alone.advance(end + 4 * 2713 - alone.next_step).forces)
        of.append(np.concatenate(run))
    fade = force[: end - 5000]
    most, least = (getattr(np, name)([each[5000:end] for each in of], axis=(0, 1)) for name in ("max", "min"))
    assert (fade.max(axis=0) < most + 0.02 * STATIC).all()
    assert (fade.min(axis=0) > least - 0.02 * STATIC).all()
    after_fade, alone = force[end - 5000 + 2713 :], of[1][end + 2713 :]
    assert np.abs(after_fade - alone).max() < 3e-3 * STATIC
