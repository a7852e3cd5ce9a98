"""Fatigue of the X40's axle: closed form, strain gauges that turn with it, and what must not depend on choices."""

from functools import cache

import numpy as np
import pytest

from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow import Rainflow
from wheelset_track_sim.fatigue.static_stress import AXIAL, static_stress
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.simulation.simulator import Simulator

pytestmark = pytest.mark.slow
CURVE = load_curve("assumed_body")
A1 = 0


@cache
def run_of(name, turns, *changes):
    """Static stress, wheel and blocks of whole turns of a scenario."""
    scenario = load_scenario(name, changes)
    simulator = Simulator(scenario)
    static = static_stress(scenario, simulator.models.reduced, scenario.output.stress_nodes)
    end, blocks = turns * simulator.steps_per_revolution, []
    while simulator.next_step < end:
        blocks.append(simulator.advance(min(end - simulator.next_step, 10_000)))
    return static, TurningWheel.of(scenario), blocks


@cache
def fatigue_of(name, turns, *changes, points=36):
    """Nodes of a scenario after whole turns."""
    static, wheel, blocks = run_of(name, turns, *changes)
    fatigue = AxleFatigue(static, wheel, CURVE, points=points)
    for block in blocks:
        fatigue.push(block)
    return fatigue.nodes


def rotating(name, turns, *changes, points=36):
    """Rotating stress of a scenario without the kernels, (nodes, points, n)."""
    static, wheel, blocks = run_of(name, turns, *changes)
    axial = np.concatenate([block.stresses[:, :, AXIAL] for block in blocks])
    turned = 2 * np.pi * (np.arange(len(axial)) - wheel.origin) / wheel.turn
    around = turned + 2 * np.pi * np.arange(points)[:, np.newaxis] / points
    vertical = static.bending_of(axial).T[:, np.newaxis] * np.cos(around)
    return static.mean[:, np.newaxis, np.newaxis] + vertical


def per_1000_km(node):
    return node.damage_in(1e6)[0]


def test_the_undamaged_axle_has_the_damage_of_its_closed_form():
    for node in fatigue_of("undamaged", 100):
        assert node.ratios[0] == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("name", ["damage_wheel_1", "flat_fresh", "flat_rounded"])
def test_36_angles_give_the_damage_of_72(name):
    for node in fatigue_of(name, 20, points=72):
        assert node.damage[::2, 0].max() == pytest.approx(node.damage[:, 0].max(), rel=0.01)


@pytest.mark.parametrize("name", ["undamaged", "damage_wheel_1", "flat_rounded"])
def test_pylife_finds_the_damage_of_shipped_cases(name):
    counting = pytest.importorskip("pylife.stress.rainflow", reason="pylife is not installed: extra fatigue")
    for node, points in zip(fatigue_of(name, 20), rotating(name, 20), strict=True):
        for found, stress in zip(node.damage[::4, 0], points[::4], strict=True):
            recorder = counting.FullRecorder()
            residue = counting.FourPointDetector(recorder=recorder).process(stress).residuals
            ranges = np.abs(np.subtract(recorder.values_from, recorder.values_to)), np.abs(np.diff(residue))
            closed, halves = (np.sum((each / 2 / CURVE.limit) ** CURVE.slope) / CURVE.knee_cycles for each in ranges)
            assert found == pytest.approx(closed + halves / 2, rel=1e-6)


def test_the_largest_range_of_a_run_is_that_of_its_start():
    """A run that settles on smooth wheels begins with an impact on a calm axle, and ``amplitude`` is one of a turn."""
    smooth, steady = "settle_on=smooth", "settle_on=surfaces"
    runs = {each: rotating("flat_rounded", 5, each)[A1] for each in (smooth, steady)}
    whole = {each: np.ptp(points, axis=1).max() / 2 for each, points in runs.items()}
    turns = {each: fatigue_of("flat_rounded", 5, each)[A1].amplitude for each in runs}
    assert whole[smooth] == pytest.approx(92.9e6, rel=2e-3)
    assert whole[steady] == pytest.approx(turns[steady], rel=0.01)
    assert turns[smooth] == pytest.approx(turns[steady], rel=1e-3)


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
