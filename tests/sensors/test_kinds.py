"""Sensors of a scenario: what is refused by name, and what a simulator makes of them."""

import numpy as np
import pytest

from support.toy import toy_scenario, toy_simulator
from wheelset_track_sim import InputError, load_scenario
from wheelset_track_sim.scenario import scenario_from

BOXES = {"type": "axle_box_acceleration"}
GAUGE = {"type": "strain_gauge", "name": "g", "y": 0.05}


def with_sensors(*sensors, **keys):
    return scenario_from({**load_scenario("undamaged").to_mapping(), **keys, "sensors": [*sensors]})


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        ({**BOXES, "rate": 30000.0}, r"sensors.0.rate = 30000 Hz has a band above half the 27777.8 steps a second"),
        ({**BOXES, "noise": 0.1}, "noise needs a sampling rate"),
        ({**BOXES, "range": 0.0}, r"sensors.0.range = 0 m/s\^2 is out of range"),
        ({"type": "accelerometer"}, "not a known type: did you mean acceleration"),
        ({**GAUGE, "y": 1.2}, "sensors.0: y = 1.2 m is not on the axle"),
        ({**GAUGE, "y": 0.75}, "sensors.0: y = 0.75 m is under the hub of wheel 2"),
        ({**GAUGE, "name": "Left"}, "name = 'Left' cannot name a topic"),
        ({"type": "acceleration", "name": "a"}, "sensor a needs one place: give at, or y and r"),
        ({"type": "acceleration", "name": "a", "at": "axle_box_3"}, "not a known node of this wheelset: did you mean"),
        ({"type": "velocity", "name": "a", "y": 0.0, "r": 0.4}, "m from the nearest node of the wheelset"),
    ],
)
def test_sensors_that_cannot_be_are_refused_by_name(sensor, words):
    with pytest.raises(InputError, match=words):
        with_sensors(sensor)


def test_sensors_of_one_topic_and_of_paper_dynamics_are_refused():
    with pytest.raises(InputError, match=r"sensors.1: topic axle_box_acceleration is that of another sensor"):
        with_sensors(BOXES, BOXES)
    with pytest.raises(InputError, match="sensors read the modes of causal dynamics"):
        with_sensors(BOXES, dynamics="paper")
    slow = [{"time": 1.0, "speed": 10.0}]
    with pytest.raises(InputError, match=r"above half the 10000 steps a second at the lowest speed"):
        with_sensors({**BOXES, "rate": 12000.0}, speed_plan=slow)


def test_an_imported_wheelset_has_its_points_and_no_gauges():
    with pytest.raises(InputError, match="known are axle_box_1, axle_box_2, middle"):
        toy_scenario(sensors=[{"type": "velocity", "name": "a", "at": "end"}])
    with pytest.raises(InputError, match="give at, one of its measuring_points"):
        toy_scenario(sensors=[{"type": "velocity", "name": "a", "y": 0.0, "r": 0.1}])
    with pytest.raises(InputError, match="a strain gauge needs a wheelset by its geometry"):
        toy_scenario(sensors=[GAUGE])


@pytest.mark.parametrize(
    ("boxes", "words"),
    [
        ({"bearing_stiffness": 1e9}, "axle_boxes has one of bearing_stiffness and bearing_damping"),
        ({"bearing_stiffness": 1e9, "bearing_damping": 1e6}, "is above the critical damping"),
        ({"bearing_stiffness": 1e9, "bearing_damping": 1e4, "mass": 0.0}, "is too little for an elastic bearing"),
        ({"bearing_stiffness": 1e8, "bearing_damping": 1e4, "stiffness": 5e7}, "is below 10 times the suspension's"),
        ({"bearing_stiffness": 1e6, "bearing_damping": 1e4}, "bearing_stiffness = 1e\\+06 N/m is out of range"),
    ],
)
def test_implausible_bearings_are_refused(boxes, words):
    with pytest.raises(InputError, match=words):
        load_scenario("undamaged", [f"wheelset.axle_boxes.{key}={value}" for key, value in boxes.items()])


def test_sensors_come_back_from_plain_data():
    scenario = with_sensors({**BOXES, "rate": 1e4, "range": "500 m/s^2", "noise": 0.2, "seed": 3}, GAUGE)
    assert scenario_from(scenario.to_mapping()) == scenario
    assert scenario.sensors[0].range == 500.0


def test_sensors_change_no_bit_of_forces_and_stresses_and_do_not_depend_on_the_blocks():
    sensors = [BOXES, {"type": "suspension_force"}, {"type": "displacement", "name": "m", "at": "middle"}]
    bare, one, other = (toy_simulator(like="damage_wheel_1", sensors=each) for each in ([], sensors, sensors))
    whole, plain = one.advance(3000), bare.advance(3000)
    assert (whole.forces == plain.forces).all()
    assert (whole.stresses == plain.stresses).all()
    assert plain.sensors == {}
    parts = [other.advance(count) for count in (1, 998, 2001)]
    for topic, signal in whole.sensors.items():
        assert (np.concatenate([part.sensors[topic] for part in parts]) == signal).all()
    assert whole.sensors["suspension_force"].mean() == pytest.approx(98.1e3, rel=0.01)
