"""What detectors beside the track read: live, from the bag and simulated again, the same to the last bit."""

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.bags import read_bag, sensor_records
from wheelset_track_sim.bags.bag import Bag
from wheelset_track_sim.bags.content import ContentError
from wheelset_track_sim.bags.definitions import serialise
from wheelset_track_sim.bags.sensor_records import parts_of, sensor_parts
from wheelset_track_sim.bags.signals import signal_names, signal_of
from wheelset_track_sim.live.run_messages import RunMessages, record
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.twin.sensor_comparison import SensorComparison
from wheelset_track_sim.wayside.watch import passages

CHANNELS = (
    "{type: shear_bridge, name: q, on: rail_1, x: 0.3}, {type: shear_bridge, name: p, on: rail_2, x: 0.3}, "
    "{type: rail_acceleration, name: a, on: rail_1, x: 0.3}"
)
STANDING = f"wayside=[{{detector: {{name: mine, band: 1000, rate: 4000, channels: [{CHANNELS}]}}, position: 2.4}}]"
CUTS = (1500, 700, 1, 1599)
TOPICS = ["wayside/mine/rail_acceleration", "wayside/mine/shear_bridge"]


def simulator():
    return toy_simulator(STANDING, like="damage_wheel_1")


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("wayside") / "run.mcap"
    run = simulator()
    with record(path, run) as push:
        for steps in CUTS:
            push(run.advance(steps))
    return path


@pytest.fixture(scope="module")
def live():
    """Block of the same run in one piece, and the message of the detector as the node publishes it."""
    run = simulator()
    messages = RunMessages(run)
    block = run.advance(sum(CUTS))
    found = [each for each in messages.push(block, summarise(block)).chunk if each.kind == "WaysideReading"]
    assert all(serialise(each.kind, each.fields) == each.cdr for each in found)
    return block, found


def test_the_bag_holds_what_was_published(bag, live):
    _, [message] = live
    assert message.topic == "wayside/mine"
    sensors = read_bag(bag).sensors
    assert [*sensors] == TOPICS
    a, q = (sensors[topic] for topic in TOPICS)
    values = message.fields["values"].reshape(3, -1)
    for name, record_, row in (("q", q, 0), ("p", q, 1), ("a", a, 2)):
        np.testing.assert_array_equal(record_.values[name], values[row])
    assert (q.unit, a.unit) == ("N", "m/s^2")
    np.testing.assert_allclose(q.time, message.fields["time"] + np.arange(len(q)) / 4000.0)
    assert q.position[0] == message.fields["position"] == 1.95
    assert message.stamp_ns == pytest.approx(1e9 * q.time[-1], abs=2)


def test_the_message_has_reading_and_truth(live):
    block, [message] = live
    [passage] = passages(simulator().scenario.wayside, simulator().scenario.track, 1e-3, [block])
    for rail, verdict in enumerate(passage.verdicts):
        assert message.fields["mean_force"][rail] == verdict.read.mean
        assert message.fields["peak_force"][rail] == verdict.read.peak
        assert message.fields["dynamic_factor"][rail] == verdict.read.dynamic_factor
        assert message.fields["true_peak_force"][rail] == block.forces[1950:3451, rail].max()


def test_simulated_again_it_is_the_same_to_the_last_bit_and_a_difference_is_found(bag):
    again = simulator()
    same = SensorComparison(again, sensor_parts(Bag(bag).reader))
    other = SensorComparison(again, (_louder(part) for part in sensor_parts(Bag(bag).reader)))
    for _ in range(2):
        block = again.advance(sum(CUTS) // 2)
        same.push(block)
        other.push(block)
    for comparison in (same, other):
        comparison.finish()
    assert same.found == dict.fromkeys(TOPICS)
    assert other.found["wayside/mine/shear_bridge"].largest > 0


def _louder(part):
    return part._replace(values={name: values * 1.01 for name, values in part.values.items()})


def test_channels_are_signals(bag):
    recorded = read_bag(bag)
    assert "wayside/mine/shear_bridge/q" in signal_names(recorded)
    signal = signal_of(recorded, "wayside/mine/rail_acceleration/a")
    values, rate = signal.evenly()
    assert (signal.unit, rate) == ("m/s^2", pytest.approx(4000.0))
    assert len(values) > 200


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("values", np.zeros(0), "its values are none, or not finite"),
        ("values", np.array([1.0, 2.0, np.nan]), "its values are none, or not finite"),
        ("values", np.zeros(4), "its 4 values are not those of 3 channels"),
        ("units", ["N"], "are not those of 3 channels"),
        ("speed", 0.0, "are not those of a run with steps"),
    ],
)
def test_a_message_that_says_what_no_run_can_have_is_refused(live, field, value, message):
    block, _ = live
    run = simulator().scenario
    [passage] = passages(run.wayside, run.track, 1e-3, [block])
    made = sensor_records.wayside_message(passage, 0)
    made.fields[field] = value
    with pytest.raises(ContentError, match=message):
        sensor_records._parts("WaysideReading", "wayside/mine", sensor_records.SimpleNamespace(**made.fields))
    assert len(parts_of(passage)) == 2
