"""What sensors give: live, from the bag and simulated again, the same to the last bit."""

import dataclasses

import numpy as np
import pytest

from support.toy import toy_models, toy_scenario, toy_simulator
from wheelset_track_sim import InputError, InputWarning
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.bags.bag import Bag
from wheelset_track_sim.bags.definitions import serialise
from wheelset_track_sim.bags.exports import FORMS, export
from wheelset_track_sim.bags.frames import columns_of
from wheelset_track_sim.bags.sensor_records import sensor_parts
from wheelset_track_sim.bags.signals import signal_names, signal_of
from wheelset_track_sim.live.run_messages import RunMessages, record
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import scenario_from
from wheelset_track_sim.simulation.simulator import Simulator
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


def test_noise_that_an_event_changes_is_recorded_and_made_again(tmp_path):
    runs = [with_noise({"axle_box_acceleration": {"noise": "30 m/s^2", "drift": 0.0}}, step=3000) for _ in range(2)]
    with record(tmp_path / "run.mcap", runs[0]) as push:
        for block in advance_all(runs[0], (2500, 2000, 1500)):
            push(block)
    recorded = read_bag(tmp_path / "run.mcap")
    sampled = recorded.sensors["axle_box_acceleration"]
    late = sampled.time > recorded.time[3000]
    quiet, loud = sampled.values["wheel_1"][~late], sampled.values["wheel_1"][late]
    assert np.std(quiet) < 5.0
    assert np.std(loud) == pytest.approx(30.0, rel=0.1)
    comparison = sensor_comparison.SensorComparison(runs[1], sensor_parts(Bag(tmp_path / "run.mcap").reader))
    for block in advance_all(runs[1], (1, 5999)):
        comparison.push(block)
    comparison.finish()
    assert comparison.found == dict.fromkeys(TOPICS)


@pytest.mark.parametrize(
    ("sensors", "told"),
    [
        ({"axle_box": {"noise": 1.0}}, "known are axle_box_acceleration"),
        ({"axle_box_acceleration": {"rate": 100.0}}, "noise, drift"),
        ({"axle_box_acceleration": {"noise": -1.0}}, "sensors.axle_box_acceleration: noise = -1 m/s.2 is out of range"),
        ({"axle_box_acceleration": {"noise": "1 kN"}}, "is not in a unit of this quantity"),
        ({"suspension_force": {"noise": 1.0}}, "sensors.suspension_force: noise needs a sampling rate"),
        ([], "is not a mapping of topics"),
    ],
)
def test_noise_that_cannot_change_is_refused(sensors, told):
    with pytest.raises(InputError, match=told):
        with_noise(sensors, step=10)


def test_of_sensors_only_noise_can_change():
    run = toy_simulator(sensors=SENSORS)
    other = dataclasses.replace(run.scenario.sensors[0], range=100.0)
    with pytest.raises(InputError, match="only noise and drift can change"):
        run.apply(dataclasses.replace(run.scenario, sensors=(other, *run.scenario.sensors[1:])))


def with_noise(noises, step):
    """A simulator on whose sensors noise changes at a step."""
    mapping = toy_scenario(sensors=SENSORS).to_mapping()
    scenario = scenario_from({**mapping, "events": [{"step": step, "sensors": noises}]})
    return Simulator(scenario, models=toy_models(scenario.sensors))


def advance_all(run, steps):
    """Blocks of so many steps, and shorter ones where something changes."""
    for count in steps:
        end = run.next_step + count
        while run.next_step < end:
            yield run.advance(end - run.next_step)


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
