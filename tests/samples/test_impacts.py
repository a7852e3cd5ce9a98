"""Impacts by hand, and the same impacts for any cut of the stream."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.impacts import Impact, ImpactDetector, ImpactSettings
from wheelset_track_sim.samples.summary import summarise

DX, STATIC = 1e-3, 98.1e3
TURN, ORIGIN = 2713, 1800
SETTINGS = ImpactSettings(threshold=200e3, separation=0.010)


def block(first, wheel_1, wheel_2=None, speed=20.0, time=None, revision=0):
    """Block at steps from ``first`` on; wheel 2 rests if it is not given."""
    forces = np.stack([wheel_1, np.full(len(wheel_1), STATIC) if wheel_2 is None else wheel_2], axis=-1)
    period = DX / speed
    start = first * period if time is None else time
    return SampleBlock(first, start, period, speed, first * DX, revision, forces, np.zeros((len(forces), 0, 6)), ())


def rest(samples, **at):
    """Force of a wheel at rest but for some steps: ``s5=3e5``."""
    force = np.full(samples, STATIC)
    for step, value in at.items():
        force[int(step[1:])] = value
    return force


def impacts(blocks, settings=SETTINGS, static=STATIC):
    detector = ImpactDetector(TURN, ORIGIN, settings)
    found = [impact for item in blocks for impact in detector.push(item, static)]
    return found, detector


def test_an_impact_by_hand():
    force = rest(60, s19=0.0, s20=0.0, s22=250e3, s23=300e3, s24=150e3, s25=240e3)
    (found,), _ = impacts([block(1000, force, revision=3)])
    assert found == Impact(
        wheel=0,
        step=1023,
        time=pytest.approx(1023 * DX / 20.0, rel=1e-15),
        speed=20.0,
        position=pytest.approx(1.023, rel=1e-15),
        revision=3,
        angle=pytest.approx((1023 - 1800 + 2713) * 2 * math.pi / 2713, rel=1e-15),
        peak_force=300e3,
        static_force=STATIC,
        duration=3 * DX / 20.0,
        contact_loss=2 * DX / 20.0,
        threshold=200e3,
    )
    assert found.dynamic_factor == pytest.approx(300 / 98.1, rel=1e-15)


@pytest.mark.parametrize(("distance", "count"), [(10, 1), (11, 2)])
def test_a_wheel_that_bounces_is_one_impact_within_the_separation(distance, count):
    force = rest(100, s20=300e3)
    force[20 + distance] = 400e3
    found, _ = impacts([block(0, force)])
    assert [item.peak_force for item in found] == [400e3] if count == 1 else [300e3, 400e3]


def test_the_threshold_itself_is_no_impact():
    assert impacts([block(0, rest(60, s5=200e3))])[0] == []
    assert len(impacts([block(0, rest(60, s5=np.nextafter(200e3, 1e9)))])[0]) == 1


def test_an_impact_is_told_when_it_is_over_and_at_the_end_of_a_run():
    found, detector = impacts([block(0, rest(15, s5=300e3))])
    assert found == []
    assert len(detector.push(block(15, rest(1)), STATIC)) == 1
    assert detector.finish() == []
    assert detector.push(block(16, rest(5, s4=500e3)), STATIC) == []
    assert [item.step for item in detector.finish()] == [20]
    assert detector.finish() == []


def test_angle_0_meets_the_rail_at_the_origin_and_again_each_turn():
    force = rest(ORIGIN + TURN + 50)
    force[[ORIGIN, ORIGIN + TURN]] = 3e5
    found, _ = impacts([block(0, force)])
    assert [item.angle for item in found] == [0.0, 0.0]


def test_contact_loss_is_that_of_the_last_turn_and_belongs_to_one_impact():
    force = rest(3 * TURN)
    force[10:20] = 0.0  # more than a turn before the first impact
    force[TURN + 90 : TURN + 95] = 0.0
    force[TURN + 100] = 300e3
    force[TURN + 103 : TURN + 106] = 0.0  # behind the peak: of the next impact
    force[TURN + 200] = 300e3
    found, _ = impacts([block(0, force)])
    period = DX / 20.0
    assert [item.contact_loss for item in found] == [5 * period, 3 * period]


def test_durations_add_up_through_a_change_of_speed():
    first, second = block(0, rest(10, s8=2.5e5, s9=3e5)), block(10, rest(30, s0=2.2e5), speed=40.0, time=0.0005)
    (found,), _ = impacts([first, second])
    assert found.duration == pytest.approx(2 * DX / 20 + DX / 40, rel=1e-15)
    assert (found.step, found.speed) == (9, 20.0)


def test_each_impact_has_the_load_and_the_revision_of_its_peak():
    detector = ImpactDetector(TURN, ORIGIN, SETTINGS)
    detector.push(block(0, rest(10, s9=250e3)), STATIC)
    (found,) = detector.push(block(10, rest(40, s2=300e3), revision=1), 2 * STATIC)
    assert (found.static_force, found.revision) == (2 * STATIC, 1)


def test_a_changed_threshold_holds_from_the_next_impact_on():
    detector = ImpactDetector(TURN, ORIGIN, SETTINGS)
    assert detector.push(block(0, rest(10, s9=250e3)), STATIC) == []
    detector.settings = dataclasses.replace(SETTINGS, threshold=400e3)
    (found,) = detector.push(block(10, rest(40, s5=210e3, s30=390e3)), STATIC)
    assert (found.threshold, found.duration) == (200e3, 2 * DX / 20.0)


def test_refusals():
    with pytest.raises(InputError, match=r"threshold = -1 N is out of range"):
        ImpactSettings(threshold=-1.0)
    decimated = dataclasses.replace(block(0, rest(10)), decimation=10)
    with pytest.raises(ValueError, match="every 10th"):
        impacts([decimated])


signals = st.lists(
    st.tuples(st.sampled_from([0.0, STATIC, STATIC, STATIC, 210e3, 250e3, 400e3]), st.integers(1, 25)),
    min_size=1,
    max_size=40,
)


@given(signals, signals, st.lists(st.integers(1, 60), max_size=60), st.integers(0, 400), st.booleans())
def test_any_cut_finds_the_same_impacts(one, other, lengths, faster_from, summaries):
    """A change of speed is a border of blocks whatever the cut."""
    turn = 97
    wheels = [np.repeat(*zip(*signal, strict=True)) for signal in (one, other)]
    samples = min(map(len, wheels))
    forces = [wheel[:samples] + np.arange(samples) % 7 * (wheel[:samples] > 0) for wheel in wheels]
    speed_at = faster_from if faster_from < samples else samples

    def found(cuts):
        detector = ImpactDetector(turn, 31, SETTINGS)
        borders = sorted({0, speed_at, samples, *(cut for cut in cuts if cut < samples)})
        result = []
        for start, stop in pairwise(borders):
            speed = 20.0 if start < speed_at else 30.0
            time = min(start, speed_at) * DX / 20.0 + max(0, start - speed_at) * DX / 30.0
            piece = block(start, forces[0][start:stop], forces[1][start:stop], speed, time)
            result += detector.push(piece, STATIC, summarise(piece) if summaries else None)
        return result + detector.finish()

    whole, cut = found([]), found(np.cumsum(lengths).tolist())
    assert len(whole) == len(cut)
    for expected, item in zip(whole, cut, strict=True):
        assert item.time == pytest.approx(expected.time, rel=1e-12)
        assert item.position == pytest.approx(expected.position, rel=1e-12)
        assert dataclasses.replace(item, time=0, position=0) == dataclasses.replace(expected, time=0, position=0)


def test_the_damaged_wheel_strikes_once_a_turn_where_the_damage_is(damaged):
    turn = damaged.steps_per_revolution
    detector = ImpactDetector(turn, damaged.models.tread_origin, ImpactSettings(threshold=200e3))
    found = []
    for _ in range(6):
        found += detector.push(damaged.advance(turn // 2), damaged.in_force.wheel_load)
    assert [item.wheel for item in found] == [0] * len(found)
    assert 2 <= len(found) <= 3
    middle = (np.array([item.angle for item in found]) + math.pi) % (2 * math.pi) - math.pi
    assert np.all(np.abs(middle) * turn * DX / (2 * math.pi) < 0.060)  # it lands behind the middle of the damage
    assert all(item.contact_loss > 0 for item in found)
