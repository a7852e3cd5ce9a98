"""The node from outside: chunks without gaps, bags, signals, parameters, lifecycle."""

import math
import os
import signal

import numpy as np
import pytest

from support.paths import ROOT
from support.service_calls import assert_gap_free
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.scenario import load_scenario

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

PERIOD = load_scenario("undamaged").step_period
RUNNING, PAUSED = 0, 1


def span(chunks):
    return chunks[-1].time + len(chunks[-1].wheel_1) * chunks[-1].step_period - chunks[0].time if chunks else 0.0


def test_ten_seconds_without_gaps_and_the_same_in_the_bag(start, client, tmp_path):
    forces = client.collect("contact_forces", "ContactForces")
    stress = client.collect("axle_stress/b1", "AxleStress")
    summaries = client.collect("summary", "LoadSummary")
    bag = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "run"}
    node = start(scenario="damage_wheel_1", real_time_factor=2.0, **bag)
    client.until(lambda: span(forces) >= 10 and span([forces[0], forces[-1]]) >= 10)
    states = client.collect("state", "SimulationState", latched=True)  # a late subscriber is told too
    client.until(lambda: states)
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert_gap_free(forces)
    both = max(stress[0].first_step, forces[0].first_step)  # one of the topics may have been heard a little earlier
    steps = [[chunk.first_step for chunk in found if chunk.first_step >= both] for found in (stress, forces)]
    assert steps[0][:50] == steps[1][:50]
    assert states[0].scenario_name == "damage_wheel_1"
    assert [(item.wheel, item.a, item.b, item.h) for item in states[0].damage] == [(1, 0.030, 0.024, 0.002)]
    assert states[0].recording == str(tmp_path / "run")

    recorded = read_bag(tmp_path / "run")
    assert recorded.steps[0] == 0
    assert len(recorded) >= forces[-1].first_step + len(forces[-1].wheel_1)
    first = forces[0].first_step
    received = np.concatenate([chunk.wheel_1 for chunk in forces])
    np.testing.assert_array_equal(received, recorded.forces[first : first + len(received), 0])
    received = np.concatenate([chunk.yy for chunk in stress])
    first = stress[0].first_step
    np.testing.assert_array_equal(received, recorded.stresses[first : first + len(received), 1, 1])
    stamps = [chunk.header.stamp.sec + 1e-9 * chunk.header.stamp.nanosec for chunk in forces]
    np.testing.assert_allclose(np.diff(stamps), np.diff([chunk.time for chunk in forces]), atol=1e-6)
    largest = max(summary.wheel_1_max_force for summary in summaries[1:])
    assert largest > 2 * 98.1e3


def test_run_of_given_duration_ends_by_itself(start, tmp_path):
    node = start(
        scenario="undamaged",
        duration=0.4,
        real_time_factor=0.0,
        record__on_start="true",
        record__directory=tmp_path,
        record__name="short",
    )
    assert node.wait() == 0, node.errors
    assert len(read_bag(tmp_path / "short")) == round(0.4 / PERIOD)


def test_signal_closes_the_bag(start, client, tmp_path, stop_signal):
    forces = client.collect("contact_forces", "ContactForces")
    node = start(scenario="undamaged", record__on_start="true", record__directory=tmp_path, record__name="cut")
    client.until(lambda: len(forces) >= 3)
    assert node.signal(stop_signal) == 0, node.errors
    recorded = read_bag(tmp_path / "cut")
    np.testing.assert_array_equal(np.diff(recorded.steps), 1)
    assert len(recorded) >= forces[-1].first_step + len(forces[-1].wheel_1)
    assert "Traceback" not in node.errors


def test_signal_while_the_models_are_built(start, client, tmp_path):
    node = start(env={"WHEELSET_TRACK_SIM_CACHE": str(tmp_path / "empty")})
    client.wait_for_state("configuring")
    assert client.get("speed") == [load_scenario("damage_wheel_1").speed]  # parameters are served meanwhile
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors


def test_refused_parameters_leave_the_stream_as_it_was(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    start(scenario="damage_wheel_1")
    client.until(lambda: forces)
    refusals = {
        "speed": (math.nan, "speed"),
        "axle_load": (math.inf, "axle_load"),
        "wheel_1__damage__h": (-0.001, "wheel_1.damage.h"),
        "wheel_1__damage__b": (0.049, None),  # fits, see below
        "wheel_2__damage__y": (1.0, "wheel_2.damage.y"),
        "scenario": ("undamaged", "read-only"),
        "duration": (1.0, "read-only"),
    }
    for name, (value, reason) in refusals.items():
        result = client.set(**{name: value})
        assert result.successful is (reason is None), name
        assert reason is None or reason in result.reason
    wide = client.set(atomically=True, speed=20.0, wheel_1__damage__b=0.049, wheel_1__damage__y=0.010)
    assert not wide.successful
    assert "beyond the tread" in wide.reason
    assert client.get("speed", "wheel_1.damage.y") == [load_scenario("damage_wheel_1").speed, 0.0]
    seen = len(forces)
    client.until(lambda: len(forces) >= seen + 5)
    assert_gap_free(forces)
    assert {chunk.revision for chunk in forces} <= {0, 1}
    assert {chunk.speed for chunk in forces} == {load_scenario("damage_wheel_1").speed}


def test_accepted_parameters_are_one_revision(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    states = client.collect("state", "SimulationState", latched=True)
    start(scenario="undamaged", acceleration=10.0)
    client.until(lambda: forces)
    changes = {"speed": 20.0, "axle_load": 180e3, "wheel_2__damage__h": 0.001, "wheel_2__damage__angle": 1.0}
    assert client.set(atomically=True, **changes).successful
    assert client.get("speed", "wheel_2.damage.h") == [20.0, 0.001]
    client.until(lambda: forces[-1].speed == 20.0 and states[-1].revision == 1)
    assert_gap_free(forces)
    changed = [chunk for chunk in forces if chunk.revision == 1]
    speeds = [chunk.speed for chunk in changed]
    assert speeds == sorted(speeds, reverse=True)
    assert (speeds[0], speeds[-1]) == (load_scenario("undamaged").speed, 20.0)
    assert (states[-1].speed, states[-1].speed_set_point) == (speeds[0], 20.0)
    assert {chunk.speed for chunk in forces if chunk.revision == 0} == {load_scenario("undamaged").speed}
    assert states[-1].first_step == changed[0].first_step
    assert states[-1].axle_load == 180e3
    assert [(item.wheel, item.h, item.angle) for item in states[-1].damage] == [(2, 0.001, 1.0)]
    assert client.set(real_time_factor=0.5, atomically=True).successful  # the pace is no matter of the scenario
    seen = len(forces)
    client.until(lambda: len(forces) > seen)
    assert forces[-1].revision == 1


def test_parameters_describe_themselves(start, client):
    from rcl_interfaces.srv import DescribeParameters, ListParameters

    start(autostart="false")
    names = client.call("list_parameters", ListParameters).result.names
    ours = [name for name in names if name not in ("use_sim_time", "start_type_description_service")]
    described = client.call("describe_parameters", DescribeParameters, names=ours).descriptors
    by_name = {item.name: item for item in described}
    assert {"scenario", "speed", "axle_load", "chunk_duration", "real_time_factor", "duration"} <= set(by_name)
    assert {f"wheel_{wheel}.damage.{of}" for wheel in (1, 2) for of in ("a", "b", "h", "angle", "y")} <= set(by_name)
    assert {"record.directory", "record.on_start", "record.name", "autostart"} <= set(by_name)
    assert all(item.description for item in described)
    read_only = {name for name, item in by_name.items() if item.read_only}
    assert {"scenario", "autostart", "record.directory", "duration"} <= read_only
    assert not {"speed", "chunk_duration", "wheel_1.damage.h"} & read_only
    limits = by_name["wheel_1.damage.h"].floating_point_range[0]
    assert (limits.from_value, limits.to_value) == (0.0, 0.010)


def test_lifecycle(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    states = client.collect("state", "SimulationState", latched=True)
    node = start(scenario="undamaged", autostart="false", chunk_duration=0.02)
    assert client.state() == "unconfigured"
    assert client.set(speed=25.0).successful  # before there is a simulator
    assert not client.transition("activate")
    assert client.transition("configure")
    client.until(lambda: states and states[-1].status == PAUSED)
    assert client.transition("activate")
    client.until(lambda: len(forces) >= 5 and states[-1].status == RUNNING)
    assert forces[0].speed == 25.0
    assert client.transition("deactivate")
    client.until(lambda: states[-1].status == PAUSED)
    paused, step = len(forces), states[-1].first_step
    assert client.set(wheel_1__damage__h=0.001).successful  # while paused
    assert client.transition("activate")
    client.until(lambda: len(forces) >= paused + 5)
    assert_gap_free(forces)
    assert any(chunk.first_step == step for chunk in forces)
    assert client.transition("deactivate")
    assert client.transition("cleanup")
    assert client.state() == "unconfigured"
    count = len(forces)
    assert client.transition("configure")
    assert client.transition("activate")
    client.until(lambda: len(forces) >= count + 3)
    assert forces[-1].first_step < forces[count - 1].first_step  # a new run
    assert client.transition("shutdown")
    assert client.state() == "finalized"
    assert node.signal(signal.SIGINT) == 0, node.errors


BAD = {
    "unknown scenario": ({"scenario": "damage_wheel_3"}, "damage_wheel_3"),
    "not finite": ({"speed": ".nan"}, "speed"),
    "out of range": ({"speed": 500.0}, "speed"),
    "wrong type": ({"chunk_duration": "soon"}, "chunk_duration"),
    "wider than the tread": ({"wheel_1.damage.b": 0.05, "wheel_1.damage.y": 0.01}, "wheel_1.damage"),
    "bag folder below a file": ({"record.on_start": "true", "record.directory": os.devnull}, os.devnull),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_start_ends_with_status_2_and_one_line(start, case):
    parameters, named = BAD[case]
    node = start("--ros-args", "--log-level", "fatal", **parameters)
    assert node.wait() == 2
    assert named in node.errors
    assert len(node.errors.strip().splitlines()) == 1


def test_bad_arguments(start):
    node = start("--fast")
    assert node.wait() == 2
    assert node.errors.startswith("wheelset-track-sim: --fast is not an argument")


def test_shipped_parameter_file(start, client):
    start("--ros-args", "--params-file", str(ROOT / "config" / "node.yaml"))
    client.wait_for_state("active")
    assert client.get("scenario", "real_time_factor") == ["damage_wheel_1", 1.0]
