"""Services and command topics of the node, as another process uses them."""

import math
import random
import threading
import time
from itertools import pairwise

import numpy as np
import pytest

from support.service_calls import SIZE_B, assert_gap_free, end, first_of, item
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.bags.tread_damage import MOST
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import load_scenario, scenario_from

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

RUNNING, PAUSED = 0, 1
SPEED = load_scenario("undamaged").speed


def test_damage_comes_into_force_at_the_step_of_the_answer(start, client, services, forces, states):
    start(scenario="undamaged")
    client.until(lambda: forces and states)
    answer = services.damage({}, {"wheel": 2, "angle": 1.0}, {"angle": 3.0, "y": 0.005}, {"h": 0.0})
    assert (answer.success, answer.message, answer.revision) == (True, "", 1)
    client.until(lambda: forces[-1].revision == states[-1].revision == 1)
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


def test_parameters_of_no_known_type_are_answered(start, client, forces):
    from rcl_interfaces.msg import Parameter, ParameterValue
    from rcl_interfaces.srv import SetParameters, SetParametersAtomically

    node = start(scenario="undamaged")
    client.until(lambda: forces)
    odd = [Parameter(name="speed", value=ParameterValue(type=99))]
    assert client.call("set_parameters", SetParameters, parameters=odd).results == []
    assert not client.call("set_parameters_atomically", SetParametersAtomically, parameters=odd).result.successful
    assert client.set(speed=30.0).successful  # the node serves on
    end(node)
    assert "set_parameters is rejected: 99 is not a valid" in node.errors + node.output


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
    assert "~/cmd/speed is rejected: speed = nan is not finite" in node.errors


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
    client.until(lambda: any("~/cmd/torque is rejected: torque = nan is not finite" in text for text in logged))
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
    client.until(lambda: forces[-1].revision == states[-1].revision == 2)
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
        recorded = read_bag(tmp_path / name)
        np.testing.assert_array_equal(recorded.steps, np.arange(len(recorded)))
        assert digest in (None, recorded.info.digest)


def test_a_new_run_that_cannot_be_recorded_stands_until_it_is_told_to_go_on(start, client, services, forces, tmp_path):
    name = "r" * 254  # with _2 it is too long
    bag = {"record__directory": tmp_path, "record__name": name, "record__on_start": "true"}
    node = start(scenario="undamaged", **bag)
    client.until(lambda: forces)
    refused = services.trigger("reset")
    assert not refused.success
    assert f"{name}_2 cannot be written" in refused.message
    assert client.state() == "inactive"
    assert services.trigger("pause").message == "paused already"
    assert services.trigger("resume").message == refused.message
    assert services.trigger("reset").success  # without a bag, of which there is none now
    seen = len(forces)
    assert services.trigger("resume").success
    client.until(lambda: len(forces) >= seen + 3)
    assert forces[seen].first_step == 0
    end(node)


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


def test_changes_and_refusals_are_logged_by_whatever_means_they_come(start, client, services, forces, states):
    from std_msgs.msg import Float64

    node = start(scenario="undamaged")
    topic = client.node.create_publisher(Float64, f"{client.name}/cmd/speed", 1)
    client.until(lambda: forces and states and topic.get_subscription_count())
    accepted = services.speed(29.0)
    assert not services.speed(1e6).success
    assert not services.trigger("stop_recording").success
    topic.publish(Float64(data=28.0))
    client.until(lambda: states[-1].revision == 2)
    topic.publish(Float64(data=-1.0))
    assert client.set(speed=27.0).successful
    assert not client.set(wheel_1__damage__h=0.5).successful
    end(node)
    logged = node.errors + node.output
    assert f"set_speed: revision 1 from step {accepted.step}" in logged
    assert "set_speed is rejected: speed = 1e+06 m/s is out of range" in logged
    assert "stop_recording is rejected: nothing is being recorded" in logged
    assert "~/cmd/speed: revision 2 from step " in logged
    assert "~/cmd/speed is rejected: speed = -1 m/s is out of range" in logged
    assert "parameters: revision 3 from step " in logged
    assert "parameters are rejected: " in logged
    assert "wheel_1.damage.h" in logged


def test_a_storm_of_requests_is_answered_whole(start, make_client):
    """Three clients send 200 requests during a change that takes long; those that find no room are told so."""
    from rclpy.qos import QoSProfile
    from wheelset_track_msgs.srv import SetIrregularities, SetSpeed

    from wheelset_track_sim.ros.turns import BUSY

    node = start(scenario="undamaged")
    clients = [make_client(f"client_{number}") for number in range(3)]
    forces = clients[0].collect("contact_forces", "ContactForces")
    clients[0].until(lambda: forces)
    changes = clients[0].node.create_client(SetIrregularities, f"{clients[0].name}/set_irregularities")
    speeds = [
        each.node.create_client(SetSpeed, f"{each.name}/set_speed", qos_profile=QoSProfile(depth=200))
        for each in clients
    ]
    assert all(each.wait_for_service(20.0) for each in (changes, *speeds))
    flats = [f"{{type: flat, on: wheel_1, length: {0.03 + 0.005 * n}, angle: {n}}}" for n in range(5)]
    long = changes.call_async(SetIrregularities.Request(irregularities=f"[{', '.join(flats)}]"))
    sent = [
        (client, speeds[client].call_async(SetSpeed.Request(speed=20.0 + 0.01 * number)))
        for number, client in enumerate([0, 1, 2] * 66 + [0, 1])
    ]
    clients[0].until(lambda: all(answer.done() for _, answer in sent))
    assert long.result().success
    for client in range(3):
        answers = [answer.result() for by, answer in sent if by == client]
        accepted = [answer.revision for answer in answers if answer.success]
        assert accepted == sorted(accepted)  # in the order in which they were sent
        assert {answer.message for answer in answers if not answer.success} <= {BUSY}
    end(node)
