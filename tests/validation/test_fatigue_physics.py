"""Fatigue of the X40's axle: closed form, strain gauges that turn with it, and what must not depend on choices."""

from functools import cache

import numpy as np
import pytest

from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow import Rainflow
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.simulation.simulator import Simulator

pytestmark = pytest.mark.slow
CURVE = load_curve("assumed_body")
A1 = 0


@cache
def fatigue_of(name, turns, *changes, points=36):
    """Nodes of a scenario after whole turns."""
    scenario = load_scenario(name, changes)
    simulator = Simulator(scenario)
    static = static_stress(scenario, simulator.models.reduced, scenario.output.stress_nodes)
    fatigue = AxleFatigue(static, TurningWheel.of(scenario), CURVE, points=points)
    while simulator.next_step < turns * simulator.steps_per_revolution:
        left = turns * simulator.steps_per_revolution - simulator.next_step
        fatigue.push(simulator.advance(min(left, 10_000)))
    return fatigue.nodes


def per_1000_km(node):
    return node.damage_in(1e6)[0]


def test_the_undamaged_axle_has_the_damage_of_its_closed_form():
    for node in fatigue_of("undamaged", 100):
        assert node.ratios[0] == pytest.approx(1.0, abs=5e-3)


def test_36_angles_give_the_damage_of_72():
    pairs = zip(fatigue_of("flat_rounded", 20), fatigue_of("flat_rounded", 20, points=72), strict=True)
    for coarse, fine in pairs:
        assert per_1000_km(coarse) == pytest.approx(per_1000_km(fine), rel=0.01)


def test_a_press_fit_changes_means_alone():
    fits = "loads.press_fit.wheels=0.25 mm", "loads.press_fit.equipment=0.25 mm"
    for with_fit, without in zip(
        fatigue_of("damage_wheel_1", 20, *fits), fatigue_of("damage_wheel_1", 20), strict=True
    ):
        assert with_fit.damage[:, 0] == pytest.approx(without.damage[:, 0], rel=1e-9)
        assert with_fit.amplitude == pytest.approx(without.amplitude, rel=1e-12)
        assert with_fit.mean > 30e6
        assert without.mean == 0.0


def test_damage_grows_with_the_breakout_and_the_flat_of_less_force_damages_most():
    """A rounded flat of 196 kN damages 1.9 times as much as a breakout of 294 kN."""
    depths = [fatigue_of("damage_wheel_1", 20, f"irregularities.0.h={h} mm")[A1] for h in (0.5, 1.0, 2.0)]
    assert [node.ratios[0] for node in depths] == pytest.approx([2.05, 2.48, 2.70], rel=0.03)
    rounded = fatigue_of("flat_rounded", 20)[A1]
    assert per_1000_km(rounded) / per_1000_km(depths[-1]) == pytest.approx(1.9, rel=0.05)
    round_about = rounded.damage[:, 0]
    assert 1.5 < round_about.max() / round_about.min() < 3.0


def test_the_first_harmonic_has_the_damage_of_all():
    """Turning gauges have the harmonics 0 to 6, the gauge at the top is turned here as the first alone."""
    angles = [*range(0, 360, 30)]
    gauge = {"type": "strain_gauge", "y": -0.4}
    gauges = [{**gauge, "name": f"at_{angle}", "angle": f"{angle} deg"} for angle in angles]
    gauges.append({**gauge, "name": "top", "turning": False})
    scenario = scenario_from(load_scenario("damage_wheel_1").to_mapping() | {"sensors": gauges})
    simulator = Simulator(scenario)
    turn = simulator.steps_per_revolution
    blocks = [simulator.advance(turn) for _ in range(20)]
    stress = {
        each: np.concatenate([block.sensors[f"strain/{each}"][:, 0] for block in blocks]) * 206e9
        for each in ("top", *(f"at_{angle}" for angle in angles))
    }
    turned = 2 * np.pi * (np.arange(20 * turn) - scenario.tread_origin) / turn
    first = np.array([stress["top"] * np.cos(turned + np.radians(angle)) for angle in angles])
    whole = np.array([stress[f"at_{angle}"] for angle in angles])
    damages = []
    for channels in (first, whole):
        count = Rainflow(len(angles), CURVE)
        count.push(channels)
        damages.append(count.spectrum.damage[:, 0])
    assert np.abs(first - whole).max() < 1e6
    assert damages[0] == pytest.approx(damages[1], rel=0.02)
    assert damages[0].max() == pytest.approx(damages[1].max(), rel=0.015)
