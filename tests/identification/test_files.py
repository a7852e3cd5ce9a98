"""Observations from CSV files and bags."""

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.identification.files import Given, read_observation
from wheelset_track_sim.live.run_messages import record

TRAIN = Given(speed=25.0, axle_load=2e5)


def written(path, heading, *columns):
    rows = np.stack(columns, axis=-1)
    path.write_text(heading + "\n" + "\n".join(",".join(map(repr, map(float, row))) for row in rows) + "\n")
    return path


@pytest.fixture
def time():
    return np.arange(500) / 5e3


def test_the_wheel_with_the_larger_peak_is_taken(tmp_path, time):
    force = 100.0 + 10 * np.sin(300 * time)
    path = written(tmp_path / "f.csv", "time [s],wheel_1 [kN],wheel_2 [kN]", time, force, force + 90 * (time == 0.05))
    found, scenario = read_observation(path, TRAIN)
    assert (found.signal, found.wheel, found.speed, found.axle_load, scenario) == ("force", "wheel_2", 25.0, 2e5, None)
    assert found.peak == 250
    assert read_observation(path, Given(wheel="wheel_1", speed=25.0, axle_load=2e5))[0].wheel == "wheel_1"


def test_a_position_becomes_a_time_by_the_speed(tmp_path, time):
    path = written(tmp_path / "f.csv", "position [m],wheel_1 [kN]", 25.0 * time, 100 + 9 * np.sin(300 * time))
    assert read_observation(path, TRAIN)[0].period == pytest.approx(2e-4)


def test_accelerations_are_read_by_their_columns(tmp_path, time):
    path = written(tmp_path / "b.csv", "time [s],box_1 [g],box_2 [g]", time, np.sin(time), 5 * np.sin(time))
    found, _ = read_observation(path, TRAIN)
    assert (found.signal, found.wheel) == ("box", "wheel_2")
    assert found.values.max() == pytest.approx(5 * 9.81 * np.sin(time).max(), rel=1e-3)


def test_a_bag_holds_speed_load_and_scenario(tmp_path):
    run = toy_simulator(like="damage_wheel_1")
    with record(tmp_path / "run.mcap", run) as push:
        while run.next_step < 4000:
            push(run.advance(1000))
    found, scenario = read_observation(tmp_path / "run.mcap")
    assert found.speed == pytest.approx(27.7777778)
    assert (found.axle_load, found.wheel) == (196200.0, "wheel_1")
    assert scenario.irregularities == ()
    with pytest.raises(InputError, match=r"--signal 'box' is not a known signal: .*known are force"):
        read_observation(tmp_path / "run.mcap", Given(signal="box"))


@pytest.mark.parametrize(
    ("heading", "given", "message"),
    [
        ("time [s],wheel_1 [kN]", Given(axle_load=2e5), "does not hold the speed: give --speed"),
        ("time [s],wheel_1 [kN]", Given(speed=25.0), "does not hold the axle load: give --axle-load"),
        ("time [s],box_1 [furlong]", TRAIN, "the unit of 'box_1 \\[furlong\\]' is not known: give m/s\\^2, m/s2, g"),
        ("time [s],left [g]", Given(speed=25.0, axle_load=2e5, signal="axle_box_acceleration"), "give a column box_1"),
        ("time [s],wheel_1 [kN]", Given(speed=25.0, axle_load=2e5, signal="noise"), "is not a known signal"),
    ],
)
def test_what_is_missing_is_said(tmp_path, time, heading, given, message):
    path = written(tmp_path / "f.csv", heading, time, 100 + np.sin(300 * time))
    with pytest.raises(InputError, match=message):
        read_observation(path, given)
