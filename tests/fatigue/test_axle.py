"""Fatigue of a turning axle: closed forms, means, cuts, and what is refused."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.toy import toy_simulator
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.static_stress import AXIAL, StaticStress, static_stress
from wheelset_track_sim.samples.block import SampleBlock

CURVE, WITH_MEAN = load_curve("assumed_body"), load_curve("assumed_body_mean_stress")
WHEEL = TurningWheel(turn=1000, origin=300, step_length=1e-3)


def at_rest(bending, mean=0.0, sideways=0.0, angle=0.0):
    """Static stress of one node."""
    each = (np.array([value]) for value in (mean, bending, sideways, math.cos(angle), math.sin(angle)))
    return StaticStress(("A1",), *each)


def block_of(axial, first_step=0):
    """Samples of one node with axial stress (n,), Pa."""
    stresses = np.zeros((len(axial), 1, 6))
    stresses[:, 0, AXIAL] = axial
    return SampleBlock(first_step, 0.0, 1e-4, 10.0, 0.0, 0, np.zeros((len(axial), 2)), stresses, ("A1",))


def fatigue_of(static, *blocks, curve=CURVE, **options):
    found = AxleFatigue(static, WHEEL, curve, **options)
    for block in blocks:
        found.push(block)
    return found


def hit(turns=40, size=30e6):
    """Bending of 60 MPa with a decaying oscillation once a turn."""
    bending, ringing = np.full(turns * WHEEL.turn, 60e6), np.arange(300)
    for turn in range(turns):
        start = turn * WHEEL.turn + 420
        bending[start : start + 300] += size * np.exp(-ringing / 80) * np.cos(ringing / 6)
    return bending


def test_constant_bending_is_one_cycle_a_turn():
    [node] = fatigue_of(at_rest(80e6), block_of(np.full(100_000, 80e6))).nodes
    per_turn = (80e6 / CURVE.limit) ** CURVE.slope / CURVE.knee_cycles
    assert node.undamaged[0] == pytest.approx(100 * per_turn, rel=1e-12)
    assert node.damage[:, 0] == pytest.approx(100 * per_turn, rel=5e-3)
    assert node.ratios[0] == pytest.approx(1.0, rel=5e-3)
    assert math.isnan(node.ratios[2])  # below the limit, the original rule has no damage to compare with
    assert node.damage_in(2 * node.distance) == pytest.approx(2 * node.damage[node.worst])
    assert node.equivalent_range == pytest.approx(160e6, rel=1e-3)
    assert node.amplitude == pytest.approx(80e6, rel=1e-9)


def test_horizontal_bending_is_in_quadrature():
    """A node 0.3 rad from the top sees a part of both: its amplitude is the hypotenuse."""
    angle = 0.3
    axial = 60e6 * math.cos(angle) + 25e6 * math.sin(angle)
    [node] = fatigue_of(at_rest(60e6, sideways=25e6, angle=angle), block_of(np.full(20_000, axial)), points=72).nodes
    assert node.undamaged_amplitude == pytest.approx(65e6)
    assert node.amplitude == pytest.approx(65e6, rel=1e-3)


def test_the_point_at_the_top_is_found_by_its_angle():
    """A peak 200 steps after angle 0 meets the rail: by then the points have turned by 72 deg."""
    bending = np.full(30_000, 60e6)
    bending[WHEEL.origin + 200 :: 1000] = 120e6
    [node] = fatigue_of(at_rest(60e6), block_of(bending), points=360).nodes
    turned = 2 * math.pi * 200 / 1000
    top = round(math.degrees(-turned)) % 360
    assert node.damage[top, 0] == node.damage[:, 0].max()


def test_36_angles_are_enough():
    damages = [fatigue_of(at_rest(60e6), block_of(hit()), points=points).nodes[0].damage for points in (36, 72)]
    assert damages[0][:, 0].max() == pytest.approx(damages[1][:, 0].max(), rel=0.01)
    assert np.array_equal(damages[0], damages[1][::2])


def test_a_press_fit_changes_means_alone():
    bending = hit()
    without = fatigue_of(at_rest(60e6), block_of(bending))
    fitted = fatigue_of(at_rest(60e6, mean=35e6), block_of(bending + 35e6))
    [one], [two] = without.nodes, fitted.nodes
    assert two.mean == 35e6
    assert two.damage == pytest.approx(one.damage, rel=1e-9)
    assert two.amplitude == pytest.approx(one.amplitude, rel=1e-12)
    spectra = without.spectrum, fitted.spectrum
    centres = [np.average(each.means, weights=each.half_cycles.sum(axis=(0, 1))) for each in spectra]
    assert centres[1] - centres[0] == pytest.approx(35e6, abs=3e6)
    [counted] = fatigue_of(at_rest(60e6, mean=35e6), block_of(bending + 35e6), curve=WITH_MEAN).nodes
    assert counted.damage[:, 0].max() > 1.2 * one.damage[:, 0].max()


def test_the_two_rows_of_opposite_points_are_of_opposite_sign():
    found = fatigue_of(at_rest(60e6), block_of(hit())).spectrum
    assert found.damage[:18] == pytest.approx(found.damage[18:], rel=2e-2)


@pytest.fixture(scope="module")
def run():
    """A toy run with damage and a change of speed: static stress, wheel and blocks."""
    simulator = toy_simulator("settle_on=surfaces", like="damage_wheel_1")
    scenario = simulator.scenario
    blocks = [simulator.advance(4000)]
    simulator.apply(dataclasses.replace(scenario, speed=20.0, acceleration=10.0))
    while simulator.next_step < 12_000:
        blocks.append(simulator.advance(12_000 - simulator.next_step))
    static = static_stress(scenario, simulator.models.reduced, scenario.output.stress_nodes)
    return static, TurningWheel.of(scenario), blocks


def cut(block, start, end):
    return dataclasses.replace(
        block,
        first_step=block.first_step + start,
        forces=block.forces[start:end],
        stresses=block.stresses[start:end],
    )


def same(one, two):
    first, second = one.saved(), two.saved()
    return first.keys() == second.keys() and all(np.array_equal(first[key], second[key]) for key in first)


@settings(max_examples=25)
@given(share=st.lists(st.floats(0, 1), max_size=12), resumed=st.booleans())
def test_cuts_and_resuming_give_the_same_bits(run, share, resumed):
    static, wheel, blocks = run
    whole, parts = (AxleFatigue(static, wheel, CURVE, points=12) for _ in range(2))
    for block in blocks:
        whole.push(block)
        borders = [0, *sorted(round(each * len(block)) for each in share), len(block)]
        for start, end in pairwise(borders):
            if start < end:
                parts.push(cut(block, start, end))
            if resumed:
                again = AxleFatigue(static, wheel, CURVE, points=12)
                again.resume(parts.saved())
                parts = again
    assert same(whole, parts)
    assert [node.damage.tolist() for node in whole.nodes] == [node.damage.tolist() for node in parts.nodes]


def test_a_thousand_cuts_give_the_same_bits(run):
    static, wheel, blocks = run
    whole, parts = (AxleFatigue(static, wheel, CURVE, points=4) for _ in range(2))
    random = np.random.default_rng(5)
    for block in blocks:
        whole.push(block)
        places = np.unique(random.integers(0, len(block), max(1, 1000 * len(block) // 12_000))).tolist()
        for start, end in pairwise(sorted({0, *places, len(block)})):
            parts.push(cut(block, start, end))
    assert same(whole, parts)


def test_steps_that_are_missing_or_decimated_are_refused():
    with pytest.raises(InputError, match="steps 100 to 150 are missing: give blocks without gaps"):
        fatigue_of(at_rest(60e6), block_of(np.zeros(100)), block_of(np.zeros(50), first_step=150))
    with pytest.raises(InputError, match="every 4th step is no stress history: give samples at full rate"):
        fatigue_of(at_rest(60e6), dataclasses.replace(block_of(np.zeros(10)), decimation=4))
    with pytest.raises(InputError, match="angles = 3 is out of range: give 4 to 720"):
        AxleFatigue(at_rest(60e6), WHEEL, CURVE, points=3)
