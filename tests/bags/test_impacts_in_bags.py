"""Impacts and peaks of turns in bags, read back by readers that know nothing of this project."""

import math

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from wheelset_track_sim.bags.bag_writer import BagWriter
from wheelset_track_sim.cli.run import run
from wheelset_track_sim.samples.impacts import Impact
from wheelset_track_sim.samples.turns import TurnPeaks

IMPACT = Impact(
    wheel=1,
    step=700,
    time=0.0252,
    speed=27.0,
    position=0.7,
    revision=2,
    angle=1.25,
    peak_force=300e3,
    static_force=100e3,
    duration=4e-4,
    contact_loss=6e-4,
    threshold=200e3,
)


def messages(path, topic):
    with AnyReader([path]) as reader:
        connections = [item for item in reader.connections if item.topic == f"/wheelset_track_sim/{topic}"]
        return [reader.deserialize(data, item.msgtype) for item, _, data in reader.messages(connections=connections)]


def test_an_impact_is_recorded_with_all_that_is_known_of_it(tmp_path, run_info, make_block):
    with BagWriter(tmp_path / "bag", run_info, start_ns=10**18) as writer:
        writer.write(make_block(0, 1000), impacts=[IMPACT])
    (found,) = messages(tmp_path / "bag", "impacts")
    assert found.header.stamp.sec * 10**9 + found.header.stamp.nanosec == 10**18 + 25_200_000
    assert found.header.frame_id == "track"
    assert found.wheel == found.WHEEL_2
    assert found.dynamic_factor == 3.0
    for name in ("step", "time", "speed", "position", "revision", "angle", "peak_force", "static_force", "duration"):
        assert getattr(found, name) == getattr(IMPACT, name), name
    assert (found.contact_loss, found.threshold) == (IMPACT.contact_loss, IMPACT.threshold)


def test_the_summary_has_the_last_turn(tmp_path, run_info, make_block):
    with BagWriter(tmp_path / "bag", run_info, start_ns=0) as writer:
        writer.write(make_block(0, 100))
        writer.write(make_block(100, 100), turn=TurnPeaks(4, (3e5, 1e5), (7e7, 8e7, 9e7)))
    before, after = messages(tmp_path / "bag", "summary")
    assert before.turns == 0
    assert math.isnan(before.wheel_1_turn_max_force)
    assert np.isnan(before.turn_max_principal).tolist() == [True] * 3
    assert (after.turns, after.wheel_1_turn_max_force, after.wheel_2_turn_max_force) == (4, 3e5, 1e5)
    assert after.turn_max_principal.tolist() == [7e7, 8e7, 9e7]


@pytest.mark.slow
def test_run_records_the_impacts_that_are_in_its_forces(tmp_path, capsys):
    assert run("damage_wheel_1", [], 0.25, tmp_path / "run.mcap", json=True) == 0
    capsys.readouterr()
    chunks = messages(tmp_path / "run.mcap", "contact_forces")
    force = np.concatenate([chunk.wheel_1 for chunk in chunks])
    impacts = messages(tmp_path / "run.mcap", "impacts")
    assert len(impacts) >= 2
    for impact in impacts:
        assert impact.wheel == impact.WHEEL_1
        assert impact.peak_force == force[impact.step] > impact.threshold
        around = force[max(0, impact.step - 50) : impact.step + 50]
        assert impact.peak_force == around.max()
        assert impact.dynamic_factor == pytest.approx(impact.peak_force / 98100.0, rel=1e-12)
    assert np.count_nonzero(force > impacts[0].threshold) > 0
    covered = np.concatenate([np.arange(impact.step - 200, impact.step + 200) for impact in impacts])
    assert set(np.flatnonzero(force > impacts[0].threshold)) <= set(covered)
    summary = messages(tmp_path / "run.mcap", "summary")[-1]
    turn = 2713
    assert summary.turns == len(force) // turn
    last = slice((summary.turns - 1) * turn, summary.turns * turn)
    assert summary.wheel_1_turn_max_force == force[last].max()
