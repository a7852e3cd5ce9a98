"""What a run says when it starts: slow waves without a vehicle, and steps that a line cannot follow."""

import dataclasses
import warnings

import numpy as np
import pytest

from support.toy import toy_models, toy_scenario, toy_simulator
from wheelset_track_sim.errors import InputWarning
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.limits import slow_waves, warn_of_limits
from wheelset_track_sim.wheelset.vehicle import Vehicle, load_vehicle


def said(scenario: Scenario) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        warn_of_limits(scenario, toy_models().reduced)
    assert all(each.category is InputWarning for each in found)
    return [str(each.message) for each in found]


def polygon(order: int, amplitude: float, *changes: str) -> Scenario:
    shape = f"irregularities=[{{type: polygon, on: wheel_1, harmonics: [{{order: {order}, amplitude: {amplitude}}}]}}]"
    return toy_scenario(shape, *changes)


def test_the_amplitude_of_slow_waves_is_that_of_their_mean_square() -> None:
    x = np.arange(6000) * 0.01
    heights = 3e-3 * np.cos(2 * np.pi * x / 20 + 1) + 4e-3 * np.sin(2 * np.pi * x / 7.5) + 1e-3 * np.sin(2 * np.pi * x)
    assert slow_waves(heights + 1.0, 0.01, longer=1.85) == pytest.approx((5e-3, 7.5))
    assert slow_waves(heights, 0.01, longer=0.5)[0] == pytest.approx(np.sqrt(26) * 1e-3)
    assert slow_waves(heights, 0.01, longer=80.0)[0] == 0.0
    assert slow_waves(np.ones(1), 0.01, longer=0.001)[0] == 0.0


def test_slow_waves_that_matter_are_named_with_their_force() -> None:
    (message,) = said(polygon(1, 0.001))
    assert message == (
        "wheel_1 has waves of 2.71 m and 1 mm in amplitude, which pass at 10.2 Hz: the suspension's upper ends cannot "
        "be held below 15 Hz, where that makes 1.97 kN of a wheel load of 98.1 kN: give a vehicle"
    )
    assert said(polygon(1, 0.0003)) == []  # 0.6 % of the wheel load
    assert said(polygon(2, 0.001)) == []  # 20 Hz
    assert len(said(polygon(2, 0.001, "speed=20"))) == 1
    assert len(said(polygon(2, 0.001, "speed_plan=[{time: 1.0, speed: 20.0}]"))) == 1
    assert said(toy_scenario(like="damage_both")) == []


def test_a_vehicle_answers_for_it_down_to_what_it_holds_itself() -> None:
    reduced = toy_models().reduced
    for scenario, count in (
        (load_scenario("long_wave"), 0),
        (dataclasses.replace(load_scenario("long_wave"), vehicle=load_vehicle("power_car")), 2),
        (dataclasses.replace(polygon(1, 0.001), wheelset=load_scenario("undamaged").wheelset, vehicle=HEAVY), 0),
    ):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            warn_of_limits(scenario, reduced)
        assert len(found) == count
        assert all("the car body cannot be held below 3 Hz" in str(each.message) for each in found)
        assert all(str(each.message).endswith("give vehicle.body_mass") for each in found)


HEAVY = Vehicle(2000.0, 4e5, 2e4)


def test_steps_that_a_line_cannot_follow_are_named_with_those_that_it_can() -> None:
    line = "track={base: ballasted_60e1, line: {bays: 80}}"
    (message,) = said(load_scenario("damage_wheel_1", [line, "speed=10"]))
    assert message == (
        "speed = 10 m/s makes steps of 100 us, and track.line follows impacts up to 66.7 us: peaks may be 12 % too "
        "high, give a step_length of 0.000625 m"
    )
    assert said(load_scenario("damage_wheel_1", [line, "speed=10", "step_length=0.000625"])) == []
    assert said(load_scenario("damage_wheel_1", [line, "speed=15"])) == []
    assert said(load_scenario("undamaged", [line, "speed=10"])) == []
    assert said(load_scenario("damage_wheel_1", ["speed=10"])) == []


def test_a_run_says_it_when_it_starts() -> None:
    with pytest.warns(InputWarning, match="wheel_1 has waves of 2.71 m"):
        toy_simulator("irregularities=[{type: polygon, on: wheel_1, harmonics: [{order: 1, amplitude: 0.001}]}]")
