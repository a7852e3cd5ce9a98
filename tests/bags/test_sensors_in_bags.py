"""What sensors give: live, from the bag and simulated again, the same to the last bit."""

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim import InputWarning
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.bags.bag import Bag
from wheelset_track_sim.bags.definitions import serialise
from wheelset_track_sim.bags.exports import FORMS, export
from wheelset_track_sim.bags.frames import columns_of
from wheelset_track_sim.bags.sensor_records import sensor_parts
from wheelset_track_sim.bags.signals import signal_names, signal_of
from wheelset_track_sim.live.run_messages import RunMessages, record
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.twin import sensor_comparison

SENSORS = [
    {"type": "axle_box_acceleration", "rate": 9000.0, "noise": 0.2, "drift": 0.1, "range": 200.0, "true_value": True},
    {"type": "suspension_force"},
    {"type": "velocity", "name": "middle", "at": "middle", "rate": 2000.0},
]
TOPICS = ["axle_box_acceleration", "axle_box_acceleration/true", "suspension_force", "velocity/middle"]
CUTS = (1500, 700, 1, 2300, 1200)


def simulator():
    return toy_simulator(like="damage_wheel_1", sensors=SENSORS)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("sensors") / "run.mcap"
    run = simulator()
    with record(path, run) as push:
        for steps in CUTS:
            push(run.advance(steps))
    return path


def live():
    """Messages of sensors of the same run, in one block, as the node publishes them."""
    run = simulator()
    messages = RunMessages(run)
    block = run.advance(sum(CUTS))
    found = [*messages.push(block, summarise(block)).chunk, *messages.finish()]
    assert all(serialise(each.kind, each.fields) == each.cdr for each in found)
    return block, found


def test_the_bag_holds_what_was_published(bag):
    block, messages = live()
    recorded = read_bag(bag)
    assert [*recorded.sensors] == TOPICS
    for topic, record_ in recorded.sensors.items():
        parts = [message.fields for message in messages if message.topic == topic]
        for name, values in record_.values.items():
            assert (np.concatenate([part[name] for part in parts]) == values).all()
        assert (record_.number == np.arange(len(record_))).all()
    true = recorded.sensors["axle_box_acceleration/true"]
    assert (true.values["wheel_1"] == block.sensors["axle_box_acceleration"][:, 0]).all()
    assert (true.time == recorded.time).all()
    assert [each.unit for each in recorded.sensors.values()] == ["m/s^2", "m/s^2", "N", "m/s"]
    sampled = recorded.sensors["axle_box_acceleration"]
    assert sampled.time == pytest.approx(np.arange(len(sampled)) / 9000.0)
    assert np.abs(sampled.values["wheel_1"]).max() == 200.0


def test_a_part_of_a_bag_has_the_samples_of_its_time(bag):
    part = read_bag(bag, start=0.05, stop=0.1)
    whole = read_bag(bag)
    for topic, record_ in part.sensors.items():
        assert part.time[0] <= record_.time[0]
        assert record_.time[-1] < part.time[-1] + part.step_period[-1]
        held = np.isin(whole.sensors[topic].number, record_.number)
        assert all((whole.sensors[topic].values[name][held] == values).all() for name, values in record_.values.items())


def test_summaries_have_peak_and_rms(bag):
    _, messages = live()
    (summary,) = (message.fields for message in messages if message.kind == "SensorSummary")
    assert summary["names"] == [
        *("axle_box_acceleration/wheel_1", "axle_box_acceleration/wheel_2"),
        *("suspension_force/wheel_1", "suspension_force/wheel_2", "velocity/middle/value"),
    ]
    assert summary["peak"][0] == 200.0
    assert 90e3 < summary["rms"][2] < 110e3


@pytest.mark.parametrize("changed", [False, True])
def test_a_second_run_is_compared_bit_by_bit(bag, changed):
    run = simulator()
    comparison = sensor_comparison.SensorComparison(run, sensor_parts(Bag(bag).reader))
    for steps in (5, 3000, sum(CUTS) - 3005):
        block = run.advance(steps)
        if changed:
            vars(block)["sensors"]["suspension_force"][3 % steps, 1] += 1e-9
        comparison.push(block)
    comparison.finish()
    found = comparison.found
    assert sorted(found) == TOPICS
    assert {topic for topic, each in found.items() if each} == ({"suspension_force"} if changed else set())
    assert not changed or found["suspension_force"].channel == "wheel_2"


def test_netcdf_has_all_sensors_and_tables_those_of_each_step(bag, tmp_path):
    pytest.importorskip("xarray")
    recorded = read_bag(bag)
    data = recorded.to_xarray()
    assert data.suspension_force_wheel_1.dims == ("time",)
    assert data.axle_box_acceleration_wheel_2.dims == ("time_of_axle_box_acceleration",)
    assert data.axle_box_acceleration_wheel_2.attrs["units"] == "m/s^2"
    columns, units = columns_of(recorded)
    assert (columns["suspension_force_wheel_2"] == recorded.sensors["suspension_force"].values["wheel_2"]).all()
    assert units["axle_box_acceleration_true_wheel_1"] == "m/s^2"
    assert "axle_box_acceleration_wheel_1" not in columns
    with pytest.warns(InputWarning, match="axle_box_acceleration, velocity/middle with a sampling rate of their own"):
        export(recorded, tmp_path / "run.csv", FORMS[".csv"])


def test_signals_are_found_by_name(bag):
    recorded = read_bag(bag)
    assert {"wheel_1", "A1_yy", "suspension_force/wheel_2", "velocity/middle/value"} <= {*signal_names(recorded)}
    signal = signal_of(recorded, "velocity/middle/value")
    values, rate = signal.evenly()
    assert rate == pytest.approx(2000.0)
    assert values is signal.values


def test_the_report_has_a_section(bag):
    pytest.importorskip("bokeh")
    from wheelset_track_sim.report import sensors, survey

    run = survey(bag)
    assert [each.topic for each in run.sensors] == TOPICS
    assert run.sensors[0].peak["wheel_1"] == 200.0
    page = sensors.section(run.sensors, "PLOT")
    assert "<td>axle_box_acceleration wheel_1</td>" in page
    assert "200 m/s²" in page
    assert sensors.sensor_plots(run.sensors, run.peak.time).children
