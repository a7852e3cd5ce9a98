"""Services and command topics of the node, as another process uses them."""

import math
import random
import signal
import threading
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("wheelset_track_msgs")

from wheelset_track_sim.recording import read
from wheelset_track_sim.recording.damage import MOST
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.yaml12 import parse

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

RUNNING, PAUSED = 0, 1
SPEED = load_scenario("undamaged").speed
SIZE_B = {"a": 0.020, "b": 0.016, "h": 0.0015}


def assert_gap_free(chunks):
    for before, after in pairwise(chunks):
        assert after.first_step == before.first_step + len(before.wheel_1)


def first_of(chunks, revision):
    return next(chunk for chunk in chunks if chunk.revision >= revision)


def end(node):
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors


class Services:
    """Calls of the node's services."""

    def __init__(self, client):
        self.client = client

    def trigger(self, name):
        return self.client.trigger(name)

    def damage(self, *damage):
        from wheelset_track_msgs.srv import SetTreadDamage

        return self.client.call("set_tread_damage", SetTreadDamage, damage=[item(**fields) for fields in damage])

    def speed(self, speed, acceleration=0.0):
        from wheelset_track_msgs.srv import SetSpeed

        return self.client.call("set_speed", SetSpeed, speed=speed, acceleration=acceleration)

    def record(self, name=""):
        from wheelset_track_msgs.srv import StartRecording

        return self.client.call("start_recording", StartRecording, again=False, name=name)

    def pressure(self, wheel, at=0):
        from wheelset_track_msgs.srv import GetContactPressure

        return self.client.call("get_contact_pressure", GetContactPressure, wheel=wheel, at=at)


def item(**fields):
    from wheelset_track_msgs.msg import TreadDamage

    return TreadDamage(**{"wheel": 1, **SIZE_B, **fields})


@pytest.fixture
def services(client):
    return Services(client)


@pytest.fixture
def forces(client):
    return client.collect("contact_forces", "ContactForces")


@pytest.fixture
def states(client):
    return client.collect("state", "SimulationState", latched=True)


def test_damage_comes_into_force_at_the_step_of_the_answer(start, client, services, forces, states):
    start(scenario="undamaged")
    client.until(lambda: forces and states)
    answer = services.damage({}, {"wheel": 2, "angle": 1.0}, {"angle": 3.0, "y": 0.005}, {"h": 0.0})
    assert (answer.success, answer.message, answer.revision) == (True, "", 1)
    client.until(lambda: forces[-1].revision == 1)
    assert first_of(forces, 1).first_step == answer.step == states[-1].first_step
    assert_gap_free(forces)
    told = [(found.wheel, found.kind, found.a, found.h, found.angle, found.y) for found in states[-1].damage]
    assert told == [(1, 0, 0.02, 0.0015, 0.0, 0.0), (2, 0, 0.02, 0.0015, 1.0, 0.0), (1, 0, 0.02, 0.0015, 3.0, 0.005)]
    # the parameters show the first of each wheel; one that is set replaces it, the further stay
    assert client.get("wheel_1.damage.a", "wheel_1.damage.h", "wheel_2.damage.angle") == [0.02, 0.0015, 1.0]
    assert client.set(wheel_1__damage__h=0.001).successful
    client.until(lambda: states[-1].revision == 2)
    assert [(found.wheel, found.h) for found in states[-1].damage] == [(1, 0.001), (2, 0.0015), (1, 0.0015)]
    assert client.set(wheel_1__damage__h=0.0).successful  # takes the first away, and keeps its place
    client.until(lambda: states[-1].revision == 3)
    assert [(found.wheel, found.angle) for found in states[-1].damage] == [(2, 1.0), (1, 3.0)]
    assert client.set(wheel_1__damage__h=0.0005).successful
    client.until(lambda: states[-1].revision == 4)
    assert [(found.h, found.angle) for found in states[-1].damage] == [(0.0005, 0.0), (0.0015, 1.0), (0.0015, 3.0)]
    again = services.damage(
        *({name: getattr(found, name) for name in ("wheel", "h", "angle", "y")} for found in states[-1].damage)
    )
    assert (again.success, again.revision) == (True, 4)  # nothing new is no revision
    answer = services.damage()
    assert (answer.success, answer.revision) == (True, 5)
    assert client.get("wheel_1.damage.h", "wheel_2.damage.h") == [0.0, 0.0]
    client.until(lambda: states[-1].revision == 5)
    assert states[-1].damage == []
    assert_gap_free(forces)


def test_speed_is_approached_from_the_step_of_the_answer(start, client, services, forces, states):
    start(scenario="undamaged")
    client.until(lambda: forces and states)
    answer = services.speed(SPEED + 2.0, 4.0)
    assert (answer.success, answer.revision) == (True, 1)
    assert client.get("speed", "acceleration") == [SPEED + 2.0, 4.0]
    client.until(lambda: forces[-1].speed == SPEED + 2.0)
    assert first_of(forces, 1).first_step == answer.step
    ramp = [chunk for chunk in forces if chunk.revision == 1 and chunk.speed < SPEED + 2.0]
    assert ramp[-1].time - ramp[0].time == pytest.approx(0.5, abs=0.15)  # 2 m/s at 4 m/s^2
    assert_gap_free(forces)
    answer = services.speed(SPEED)  # the acceleration stays
    assert answer.revision == 2
    assert client.get("acceleration") == [4.0]
    assert states[-1].speed_set_point in (SPEED, SPEED + 2.0)
    client.until(lambda: states[-1].revision == 2)
    assert states[-1].speed_set_point == SPEED


def test_commands_by_topic_lead_to_the_same_revisions(start, client, forces, states):
    from std_msgs.msg import Float64
    from wheelset_track_msgs.msg import TreadDamageArray

    node = start(scenario="undamaged")
    speed = client.node.create_publisher(Float64, f"{client.name}/cmd/speed", 1)
    damage = client.node.create_publisher(TreadDamageArray, f"{client.name}/cmd/tread_damage", 1)
    client.until(lambda: forces and states and speed.get_subscription_count() and damage.get_subscription_count())
    speed.publish(Float64(data=30.0))
    client.until(lambda: states[-1].revision == 1)
    assert states[-1].speed_set_point == 30.0
    for _ in range(3):  # a slider that stands still makes no revisions
        speed.publish(Float64(data=30.0))
    speed.publish(Float64(data=math.nan))
    damage.publish(TreadDamageArray(damage=[item(h=0.5)]))
    damage.publish(TreadDamageArray(damage=[item(wheel=2)]))
    client.until(lambda: states[-1].revision == 2)
    assert [found.wheel for found in states[-1].damage] == [2]
    assert client.get("speed", "wheel_2.damage.h") == [30.0, SIZE_B["h"]]
    assert_gap_free(forces)
    end(node)
    assert "~/cmd/speed is refused: speed = nan is not finite" in node.errors


def test_torque_by_topic_turns_the_axle(start, client, forces, states):
    from rcl_interfaces.msg import Log
    from std_msgs.msg import Float64

    node = start(scenario="braking_torque")
    logged = []
    client.node.create_subscription(Log, "/rosout", lambda log: logged.append(log.msg), 100)
    beside_the_wheel = client.collect("axle_stress/a1", "AxleStress")
    between_the_discs = client.collect("axle_stress/b2", "AxleStress")
    torque = client.node.create_publisher(Float64, f"{client.name}/cmd/torque", 1)
    client.until(lambda: forces and states and beside_the_wheel and torque.get_subscription_count())
    torque.publish(Float64(data=4000.0))
    client.until(lambda: states[-1].revision == 1)
    loads = scenario_from(parse(states[-1].scenario, "the state")).loads
    assert (loads.torque, loads.torque_plan) == (4000.0, ())
    shear = 8 * 4000.0 / (math.pi * 0.165**3)
    client.until(lambda: beside_the_wheel[-1].xy[-1] > shear)
    assert np.abs(between_the_discs[-1].xy).max() < 0.01 * shear  # each disc is held by its own rail
    torque.publish(Float64(data=math.nan))
    client.until(lambda: any("~/cmd/torque is refused: torque = nan is not finite" in text for text in logged))
    assert states[-1].revision == 1
    assert_gap_free(forces)
    end(node)


def test_refusals_say_quantity_value_and_limit_and_change_nothing(start, client, services, forces, states):
    node = start(scenario="damage_wheel_1")
    client.until(lambda: forces and states)
    for answer, reason in (
        (services.speed(math.nan), "speed = nan is not finite: give the running speed from 5 to 100 m/s"),
        (services.speed(200.0), "speed = 200 m/s is out of range: give the running speed from 5 to 100 m/s"),
        (services.speed(30.0, 50.0), "acceleration = 50 m/s^2 is out of range"),
        (services.damage({}, {"h": -0.001}), "damage.1.h = -0.001 m is out of range: give depth from 0 to 0.01 m"),
        (services.damage({"a": math.inf}), "damage.0.a = inf is not finite"),
        (services.damage({"y": 0.049}), "damage.0.b = 0.016 m at y = 0.049 m reaches 0.065 m"),
        (services.damage({"wheel": 0}), "damage.0.wheel = 0 is not a wheel: give 1"),
        (services.damage({"kind": 9}), "damage.0.kind = 9 is not a kind of damage"),
        (services.damage(*[{}] * (MOST + 1)), f"damage has {MOST + 1} entries: give at most {MOST}"),
        (services.damage(*[{"h": 0.010}] * 3), "tread of wheel_1 is 0.03 m deep"),
    ):
        assert (answer.success, answer.revision) == (False, 0)
        assert answer.message.startswith(reason)
    seen = len(forces)
    client.until(lambda: len(forces) >= seen + 5)
    assert_gap_free(forces)
    assert {chunk.revision for chunk in forces} == {0}
    assert [found.h for found in states[-1].damage] == [0.002]
    assert client.get("speed", "wheel_1.damage.h") == [SPEED, 0.002]
    end(node)


@pytest.mark.parametrize("way", ["service", "parameters"])
def test_a_change_that_takes_long_holds_up_nothing_else(start, client, services, forces, way):
    start(scenario="undamaged")
    client.until(lambda: forces)
    depth = random.SystemRandom().uniform(0.001, 0.0011)  # new to every cache
    many = [{"wheel": 1 + n % 2, "angle": 0.4 * n, "h": depth + 1e-7 * n, "y": 0.001 * (n % 5)} for n in range(10)]
    long = {"wheel_2.damage.a": 0.12, "wheel_2.damage.h": depth, "wheel_2.damage.y": 0.004}  # no symmetry
    answers = []

    def change():
        answers.append(services.damage(*many) if way == "service" else client.set(atomically=True, **long))

    waiting = threading.Thread(target=change)
    waiting.start()
    other = type(services)(type(client)(client.node, client.running))
    time.sleep(0.2)
    seen = len(forces)
    assert other.client.get("wheel_1.damage.h", "wheel_2.damage.h") == [0.0, 0.0]
    assert other.client.state() == "active"
    assert other.pressure(1).success
    assert other.trigger("pause").success
    assert other.trigger("resume").success
    assert not answers
    client.until(lambda: len(forces) >= seen + 3)
    assert not answers
    behind = other.client.set(axle_load=180e3)  # is a change, too: the next
    waiting.join()
    assert behind.successful
    assert behind.reason.startswith("revision 2 from step") or not behind.reason  # it was asked again
    client.until(lambda: forces[-1].revision == 2)
    assert answers[0].success if way == "service" else answers[0].successful
    assert_gap_free(forces)


def test_a_signal_breaks_off_a_change_that_takes_long(start, client, services, forces):
    node = start(scenario="undamaged")
    client.until(lambda: forces)
    depth = random.SystemRandom().uniform(0.001, 0.0011)
    many = [
        {"wheel": 1 + n % 2, "angle": 0.12 * (n // 2), "h": depth + 1e-6 * n, "y": 0.001 * (n % 5)} for n in range(100)
    ]
    answers = []
    waiting = threading.Thread(target=lambda: answers.append(services.damage(*many)), daemon=True)  # minutes
    waiting.start()
    time.sleep(3.0)
    assert not answers
    running = client.running.copy()
    client.running.clear()  # it is meant to end
    end(node)
    assert running == [node]


def test_pause_and_resume_are_the_transitions_of_the_lifecycle(start, client, services, forces, states):
    node = start(scenario="undamaged", autostart="false")
    assert client.state() == "unconfigured"
    for name in ("pause", "resume", "reset", "start_recording", "split_recording", "stop_recording"):
        answer = services.record() if name == "start_recording" else services.trigger(name)
        assert not answer.success
        assert "configure the node first" in answer.message
    assert "configure the node first" in services.pressure(1).message
    assert client.transition("configure")
    assert "activate the node first" in services.pressure(1).message
    assert services.trigger("resume").success
    assert client.state() == "active"
    client.until(lambda: len(forces) >= 3 and states[-1].status == RUNNING)
    assert services.trigger("resume").message == "running already"
    assert services.trigger("pause").success
    assert client.state() == "inactive"
    client.until(lambda: states[-1].status == PAUSED)
    paused = states[-1].first_step
    again = services.trigger("pause")
    assert (again.success, again.message) == (True, "paused already")
    answer = services.speed(30.0)  # while paused, in force where it stands
    assert answer.step == paused
    assert services.trigger("resume").success
    client.until(lambda: forces[-1].revision == 1)
    assert first_of(forces, 1).first_step == paused
    assert_gap_free(forces)
    end(node)


def test_reset_begins_a_new_run_with_what_is_in_force(start, client, services, forces, states, tmp_path):
    bag = {"record__directory": tmp_path, "record__name": "run", "record__on_start": "true"}
    node = start(scenario="damage_wheel_1", **bag)
    client.until(lambda: forces and states)
    assert services.speed(30.0, 10.0).success
    assert services.damage({"wheel": 2}).success
    client.until(lambda: forces[-1].revision == 2)
    last = len(states)
    answer = services.trigger("reset")
    assert answer.success
    assert answer.message == f"a new run from step 0, recorded to {tmp_path / 'run_2'}"
    client.until(lambda: any(after.first_step < before.first_step for before, after in pairwise(forces)))
    client.until(lambda: any(state.status == RUNNING for state in states[last:]))
    begun = next(state for state in states[last:] if state.status == RUNNING)
    assert (begun.first_step, begun.revision, begun.speed) == (0, 0, 30.0)
    assert [found.wheel for found in begun.damage] == [2]
    assert begun.recording == str(tmp_path / "run_2")
    assert client.get("speed", "wheel_1.damage.h", "wheel_2.damage.h") == [30.0, 0.0, SIZE_B["h"]]
    number = next(index for index, chunk in enumerate(forces) if index and chunk.first_step == 0)
    assert_gap_free(forces[:number])
    assert_gap_free(forces[number:])
    stamps = [chunk.header.stamp.sec * 10**9 + chunk.header.stamp.nanosec for chunk in forces]
    assert (np.diff(stamps) > 0).all()
    assert services.trigger("pause").success
    assert services.trigger("reset").success  # stands at the start of a third run
    assert client.state() == "inactive"
    client.until(lambda: (states[-1].status, states[-1].first_step) == (PAUSED, 0))
    assert states[-1].recording == ""
    assert services.trigger("resume").success
    client.until(lambda: states[-1].recording == str(tmp_path / "run_3"))
    end(node)
    for name, digest in (("run", None), ("run_2", begun.digest), ("run_3", begun.digest)):
        recorded = read(tmp_path / name)
        np.testing.assert_array_equal(recorded.steps, np.arange(len(recorded)))
        assert digest in (None, recorded.info.digest)


def test_recordings_start_split_and_stop_while_it_streams(start, client, services, forces, states, tmp_path):
    node = start(scenario="damage_wheel_1", record__directory=tmp_path, chunk_duration=0.02)
    client.until(lambda: len(forces) > 5 and states)
    assert services.trigger("stop_recording").message == "nothing is being recorded: start a recording first"
    assert not services.trigger("split_recording").success
    answer = services.record("day 1/run")
    assert (answer.success, answer.message, answer.path) == (True, "", str(tmp_path / "day 1" / "run"))
    first = answer.first_step
    client.until(lambda: states[-1].recording == answer.path)
    again = services.record("other")
    assert (again.success, again.path) == (False, answer.path)
    assert "is being recorded: stop it first" in again.message
    files = ["run_0.mcap"]
    for number in (1, 2):
        seen = len(forces)
        client.until(lambda seen=seen: len(forces) > seen + 10)
        split = services.trigger("split_recording")
        assert split.success
        assert split.message == str(tmp_path / "day 1" / "run" / f"run_{number}.mcap")
        files.append(f"run_{number}.mcap")
    assert services.trigger("pause").success
    assert services.trigger("resume").success
    assert services.speed(30.0).success
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 10)
    stopped = services.trigger("stop_recording")
    assert (stopped.success, stopped.message) == (True, answer.path)
    client.until(lambda: states[-1].recording == "")
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 3)  # it streams on
    unnamed = services.record()
    assert unnamed.success
    assert Path(unnamed.path).parent == tmp_path
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 3)
    end(node)
    assert_gap_free(forces)

    recorded = read(tmp_path / "day 1" / "run")
    assert recorded.steps[0] == first
    np.testing.assert_array_equal(np.diff(recorded.steps), 1)
    received = {chunk.first_step: chunk for chunk in forces}
    part = received[first]
    np.testing.assert_array_equal(part.wheel_1, recorded.forces[: len(part.wheel_1), 0])
    assert recorded.states[0].first_step == first
    assert recorded.states[-1].revision == 1
    alone = [read(tmp_path / "day 1" / "run" / file) for file in files]
    assert sum(len(part) for part in alone) == len(recorded)
    for part in alone:  # each file tells what it holds
        assert part.states[0].first_step == part.steps[0]
        assert part.states[0].recording == answer.path
    assert read(unnamed.path).steps[0] == unnamed.first_step > recorded.steps[-1]


def test_bags_over_ros_stay_below_the_folder(start, client, services, forces, tmp_path):
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / "link").symlink_to(tmp_path)
    node = start(scenario="undamaged", record__directory=tmp_path / "recordings")
    client.until(lambda: forces)
    for name in ("../run", "a/../../run", str(tmp_path / "run"), "link/run", ".", "~/../run"):
        answer = services.record(name)
        assert (answer.success, answer.path) == (False, "")
        assert "leads out of" in answer.message
    assert "200" in services.record("x" * 100_000).message
    assert "cannot be printed" in services.record("a\nb").message
    (tmp_path / "recordings" / "taken").mkdir()
    assert "exists already" in services.record("taken").message
    assert sorted(path.name for path in tmp_path.rglob("*") if path.suffix == ".mcap") == []
    assert services.record("run").success
    end(node)


def test_pressure_now_and_at_the_worst_impact(start, client, services, forces, states):
    summaries = client.collect("summary", "LoadSummary")
    start(scenario="damage_wheel_1")
    client.until(lambda: forces and sum(len(chunk.wheel_1) for chunk in forces) > 2 * 2713)
    assert services.trigger("pause").success  # so that the latest step is the last that arrived
    client.until(lambda: states and states[-1].status == PAUSED)
    client.until(lambda: summaries[-1].first_step + summaries[-1].samples == states[-1].first_step)
    steps = np.concatenate([chunk.first_step + np.arange(len(chunk.wheel_1)) for chunk in forces])
    of_wheel = {wheel: np.concatenate([getattr(chunk, f"wheel_{wheel}") for chunk in forces]) for wheel in (1, 2)}
    for wheel in (1, 2):
        latest = services.pressure(wheel, 0)
        assert latest.success, latest.message
        assert latest.step == states[-1].first_step - 1 == steps[-1]
        assert latest.force == pytest.approx(of_wheel[wheel][-1], rel=1e-6)
        assert_equilibrium(latest)
        worst = services.pressure(wheel, 1)
        assert_equilibrium(worst)
        assert worst.force >= of_wheel[wheel].max() * (1 - 1e-6)
        if worst.step >= steps[0]:
            assert worst.step == steps[of_wheel[wheel].argmax()]
    impact = services.pressure(1, 1)
    assert impact.force > 2.5 * 98.1e3
    assert min(impact.angle, 2 * math.pi - impact.angle) * 0.43175 < 0.060  # the damage is at angle 0
    assert impact.position == pytest.approx(impact.step * 1e-3, rel=1e-12)
    assert impact.time == pytest.approx(impact.position / impact.speed, rel=1e-9)
    assert (impact.header.frame_id, impact.revision) == ("track", 0)
    assert services.damage().success
    assert services.trigger("resume").success
    client.until(lambda: forces[-1].revision == 1)
    again = services.pressure(1, 1)  # of the treads that were, in a run that has gone on
    assert (again.step, again.pressure) == (impact.step, impact.pressure)
    assert services.pressure(1, 0).step > impact.step
    assert "wheel = 3 is not a wheel" in services.pressure(3).message
    assert "at = 2 is not known" in services.pressure(1, 2).message
    assert services.trigger("reset").success
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 1)
    assert services.pressure(1, 1).force < 1.2 * 98.1e3  # since the start of this run


def assert_equilibrium(found):
    pressure = np.reshape(found.pressure, (found.rows, found.columns))
    assert (pressure >= 0).all()
    assert pressure.sum() * found.dx * found.dy == pytest.approx(found.force, rel=1e-9)
    inside = np.argwhere(pressure > 0)
    x, y = found.x0 + inside[:, 0] * found.dx, found.y0 + inside[:, 1] * found.dy
    assert np.abs(x).max() < 0.03
    assert np.abs(y).max() < 0.03


def test_parameters_one_by_one_atomically_and_from_a_file_at_the_start(start, client, forces, states, tmp_path):
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    file = tmp_path / "node.yaml"
    file.write_text(
        "/wheelset_track_sim:\n  ros__parameters:\n    scenario: undamaged\n    speed: 30.0\n    acceleration: 3.0\n"
        "    axle_load: 180000.0\n    wheel_2:\n      damage: {a: 0.02, b: 0.016, h: 0.001, angle: 1.0}\n"
    )
    start("--ros-args", "--params-file", str(file))
    client.until(lambda: forces and states)
    assert (states[-1].revision, states[-1].speed, states[-1].axle_load) == (0, 30.0, 180e3)
    assert [(found.wheel, found.a, found.b, found.h, found.angle) for found in states[-1].damage] == [
        (2, 0.02, 0.016, 0.001, 1.0)
    ]
    one_by_one = {
        "speed": 31.0,
        "wheel_2.damage.y": 0.04,
        "axle_load": 190e3,
        "wheel_2.damage.b": 0.5,
        "wheel_1.damage.h": 1e-3,
    }
    wanted = [Parameter(name, value=value).to_parameter_msg() for name, value in one_by_one.items()]
    results = client.call("set_parameters", SetParameters, again=False, parameters=wanted).results
    assert [result.successful for result in results] == [True, False, True, False, True]
    assert "y = 0.04 m reaches 0.056 m" in results[1].reason
    assert [result.reason.partition(" from")[0] for result in results[::2]] == [f"revision {n}" for n in (1, 2, 3)]
    client.until(lambda: states[-1].revision == 3)
    assert (states[-1].speed_set_point, states[-1].axle_load) == (31.0, 190e3)
    assert {(found.wheel, found.h, found.y) for found in states[-1].damage} == {(1, 1e-3, 0.0), (2, 1e-3, 0.0)}
    refused = client.set(atomically=True, speed=32.0, wheel_2__damage__y=0.04)
    assert not refused.successful
    both = client.set(atomically=True, speed=32.0, wheel_2__damage__y=0.03)
    assert both.reason.startswith("revision 4 from step ")
    client.until(lambda: states[-1].revision == 4)
    assert states[-1].first_step == int(both.reason.rpartition(" ")[2])
    assert client.get("speed", "wheel_2.damage.y") == [32.0, 0.03]
    assert client.set(atomically=True, speed=32.0).reason == ""  # nothing new is no revision
    assert_gap_free(forces)


def irregularities(client, text):
    from wheelset_track_msgs.srv import SetIrregularities

    return client.call("set_irregularities", SetIrregularities, irregularities=text)


def test_any_irregularity_changes_live_and_goes_on_without_a_jump(start, client, forces, states, tmp_path):
    from std_msgs.msg import String

    (tmp_path / "below").mkdir()
    for path in (tmp_path / "outside.csv", tmp_path / "below" / "tread.csv"):
        path.write_text("".join(f"{angle},{0.02 * math.cos(math.radians(angle))}\n" for angle in range(360)))
    start(scenario="damage_wheel_1", profiles__directory=str(tmp_path / "below"))
    client.until(lambda: forces and states)
    kinds = (
        "[{type: breakout, on: wheel_2, a: 0.02, b: 0.01, h: 0.001, angle: 2.0},"
        " {type: squat, on: rail_1, position: 30.0, a: 0.02, b: 0.01, h: 0.0005},"
        " {type: polygon, on: wheel_1, harmonics: [{order: 3, amplitude: 1.0e-4}]}]"
    )
    answer = irregularities(client, kinds)
    assert (answer.success, answer.message, answer.revision) == (True, "", 1)
    client.until(lambda: forces[-1].revision == 1)
    assert first_of(forces, 1).first_step == answer.step == states[-1].first_step
    assert [(found.wheel, found.angle) for found in states[-1].damage] == [(2, 2.0)]
    assert [each.type for each in scenario_from(parse(states[-1].scenario, "state")).irregularities] == [
        "breakout",
        "squat",
        "polygon",
    ]
    assert client.get("wheel_1.damage.h", "wheel_2.damage.h") == [0.0, 0.001]
    # what cannot be used is refused whole, by name
    for text, words in (
        ("[{type: flat, on: wheel_1, length: 9.0}]", "irregularities.0.length = 9 m"),
        ("[{type: crater, on: wheel_1}]", "irregularities.0.type = 'crater'"),
        ("[&a [1], *a]", "alias"),
        ("[" * 200_000, "nested more than 20 times"),
        ("[{type: profile, on: wheel_1, file: ../outside.csv, along: deg, height: mm}]", "leads out of"),
        (f"[{{type: profile, on: wheel_1, file: {tmp_path}/outside.csv, along: deg, height: mm}}]", "leads out of"),
        ("#" * (256 * 1024 + 1), "give at most 262144"),
    ):
        refused = irregularities(client, text)
        assert (refused.success, refused.revision) == (False, 1), text[:60]
        assert words in refused.message
        assert "\n" not in refused.message
    # a topic does the same; a file below the folder becomes part of the scenario
    publisher = client.node.create_publisher(String, f"{client.name}/cmd/irregularities", 1)
    client.until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data="[{type: profile, on: wheel_1, file: tread.csv, along: deg, height: mm}]"))
    client.until(lambda: forces[-1].revision == 2)
    assert "359.0 0.0199" in states[-1].scenario
    # tread damage replaces what is on the treads
    assert client.set(wheel_2__damage__h=0.0005).successful
    client.until(lambda: forces[-1].revision >= 3)
    assert_gap_free(forces)
    before, after = forces[-2], forces[-1]
    assert all(0.0 <= value < 4e5 for chunk in (before, after) for value in chunk.wheel_1)
