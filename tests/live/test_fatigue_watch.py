"""Fatigue while a run streams: reports once a second, the same as from the bag, kept in a ledger."""

import dataclasses

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.bags import Bag
from wheelset_track_sim.bags.definitions import deserialise
from wheelset_track_sim.bags.window import RunWindow
from wheelset_track_sim.cli.fatigue import counted
from wheelset_track_sim.cli.fatigue_ledger import identity_of
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.ledger import load_ledger
from wheelset_track_sim.live.fatigue_watch import FatigueSettings, FatigueWatch
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

CURVE = load_curve("assumed_body")
SETTINGS = FatigueSettings(CURVE, "axle 7", angles=8)
STEPS = 60_000
START = 1_700_000_000 * 10**9


def streamed(chunk, settings=SETTINGS, steps=STEPS, start_ns=0):
    run = toy_simulator(like="damage_wheel_1")
    watch = FatigueWatch(run, settings)
    reports = []
    while run.next_step < steps:
        reports += watch.push(run.advance(min(chunk, steps - run.next_step)), start_ns)
    return watch, reports


@pytest.fixture(scope="module")
def reports():
    return streamed(5000)[1]


def test_reports_come_once_a_second_at_the_first_step_after_it(reports):
    assert [report.fields["next_step"] for report in reports] == [27778, 55556]
    for second, report in enumerate(reports, 1):
        assert report.fields["time"] == pytest.approx(second, abs=3.7e-5)
        assert report.fields["distance"] == pytest.approx(report.fields["next_step"] * 1e-3)
        assert report.fields["curve_assumed"] is True
        message = deserialise("Fatigue", report.cdr)
        assert message.nodes == ["A1", "B1", "C1"]
        assert len(message.damage) == 3 * 8 * len(message.rules)
        assert (message.window_damage > 0).all()
    first, second = (report.fields["damage"].reshape(3, 8, 3)[..., 0] for report in reports)
    worst = second.argmax(axis=1)
    rows = np.arange(3)
    expected = 1e3 * (second - first)[rows, worst] / (27778 * 1e-3)
    np.testing.assert_allclose(reports[1].fields["window_damage"], expected)


@pytest.mark.parametrize("chunk", [1389, 27778])
def test_reports_do_not_depend_on_the_chunks(reports, chunk):
    assert [each.cdr for each in streamed(chunk)[1]] == [each.cdr for each in reports]


@pytest.mark.slow
def test_what_is_told_live_is_what_the_bag_gives(tmp_path, reports):
    path = tmp_path / "run.mcap"
    run = toy_simulator(like="damage_wheel_1")
    with record(path, run, fatigue=SETTINGS) as push:
        while run.next_step < STEPS:
            push(run.advance(min(1389, STEPS - run.next_step)))
    found = [*Bag(path).reader.messages(("Fatigue",), lambda message: message)]
    assert [each.next_step for each in found] == [27778, 55556, STEPS]
    assert found[-1].run == identity_of(str(path), [])
    for message in found:
        fatigue, _ = counted(str(path), [], CURVE, message.distance, angles=8, gate=None)
        assert fatigue.steps == message.next_step
        assert message.damage.tobytes() == fatigue.damage.tobytes()
        assert message.amplitude.tolist() == [node.amplitude for node in fatigue.nodes]
    np.testing.assert_array_equal(found[0].damage, reports[0].fields["damage"])
    blocks = Bag(path).blocks(RunWindow(first_step=0))
    assert sum(map(len, blocks)) == STEPS  # its messages do not disturb the others


def test_the_ledger_holds_checkpoints_and_the_end(tmp_path):
    path = tmp_path / "axle.ledger"
    settings = dataclasses.replace(SETTINGS, ledger=path, checkpoint=10.0)
    watch, _ = streamed(1389, settings, 12_000, START)
    last = watch.finish(START)
    assert watch.finish(START) == []
    (entry,) = load_ledger(path).entries
    assert (entry.steps, entry.axle, entry.run, bool(entry.state)) == (12_000, "axle 7", last[0].fields["run"], False)
    assert entry.damage.tobytes() == last[0].fields["damage"].tobytes()


def test_a_run_that_is_killed_leaves_a_checkpoint_that_its_bag_completes(tmp_path):
    path = tmp_path / "axle.ledger"
    watch, _ = streamed(1389, SETTINGS, 9_000, START)
    assert watch.save(path, START) == "new"
    (entry,) = load_ledger(path).entries
    assert entry.state
    whole, _ = streamed(1389, SETTINGS, 12_000, START)
    assert whole.save(path, START) == "longer"
    assert [each.steps for each in load_ledger(path).entries] == [12_000]


def test_cycles_of_a_point(reports):
    watch, _ = streamed(5000)
    worst = watch.spectrum("A1", None)
    assert worst.angle == pytest.approx(watch.nodes[0].angle)
    assert worst.spectrum.damage[0].tolist() == watch.nodes[0].damage[watch.nodes[0].worst].tolist()
    assert watch.spectrum("A1", worst.angle + 0.1).angle == worst.angle
    with pytest.raises(InputError, match="node = 'Z9' is not counted: give one of A1, B1, C1"):
        watch.spectrum("Z9", 0.0)
    with pytest.raises(InputError, match="angle = nan is not finite"):
        watch.spectrum("A1", float("nan"))


def test_before_the_first_step_there_is_nothing():
    watch = FatigueWatch(toy_simulator(), SETTINGS)
    with pytest.raises(InputError, match="there is no step yet"):
        watch.spectrum("A1", 0.0)
    assert watch.finish(0) == []


@pytest.mark.slow
def test_a_torque_that_bends_the_axle_stops_the_count():
    told = []
    bent = ["loads.torque_plan=[]", "loads.torque=-7000", "loads.horizontal_bending=true"]
    run = Simulator(load_scenario("braking_torque", bent))
    watch = FatigueWatch(run, SETTINGS, told.append)
    watch.push(run.advance(3000), 0)
    other = dataclasses.replace(run.scenario.loads, torque=run.scenario.loads.torque / 2)
    run.apply(dataclasses.replace(run.scenario, loads=other))
    assert watch.push(run.advance(3000), 0) == []
    assert told[0].startswith("fatigue is no longer counted: loads.horizontal_bending follows a torque")
    assert watch.nodes[0].distance == pytest.approx(3.0)


@pytest.mark.parametrize(("key", "value"), [("angles", 3), ("checkpoint", 0.0), ("axle", " "), ("mark", 7.0)])
def test_settings_out_of_range_are_refused(key, value):
    with pytest.raises(InputError, match=key):
        dataclasses.replace(SETTINGS, **{key: value})
