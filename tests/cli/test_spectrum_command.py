"""``spectrum`` of a bag."""

import csv
import json

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.live.run_messages import record

SENSORS = [{"type": "axle_box_acceleration", "rate": 9000.0}, {"type": "velocity", "name": "middle", "at": "middle"}]


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("spectrum") / "run.mcap"
    run = toy_simulator(like="damage_wheel_1", sensors=SENSORS)
    with record(path, run) as push:
        for _ in range(4):
            push(run.advance(2713))
    return path


def printed(capsys, *arguments):
    assert main(["spectrum", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_narrow_band_has_the_variance_of_the_signal(bag, capsys, tmp_path):
    out = tmp_path / "force.csv"
    found = printed(capsys, bag, "--signal", "wheel_1", "--resolution", "10", "--out", out)
    assert found["rms"] ** 2 == pytest.approx(read_bag(bag).forces[:, 0].var(), rel=0.25)
    assert found["rms"] ** 2 == pytest.approx(sum(found["density_per_Hz"]) * found["resolution_Hz"])
    assert (found["kind"], found["unit"]) == ("narrow_band", "N")
    rows = list(csv.reader(out.read_text().splitlines()))
    assert rows[0] == ["frequency_Hz", "density_per_Hz"]
    assert [float(row[1]) for row in rows[1:]] == found["density_per_Hz"]


def test_bands_of_a_sensor_end_below_half_its_rate(bag, capsys):
    found = printed(capsys, bag, "--signal", "axle_box_acceleration/wheel_1", "--third-octave")
    assert found["rate_Hz"] == pytest.approx(9000.0)
    assert found["reference"] == 1e-6
    assert max(found["frequency_Hz"]) * 10**0.05 <= 4500.0
    assert found["level_dB"] == pytest.approx(20 * np.log10(np.array(found["rms"]) / 1e-6))


def test_orders_and_the_mean_turn_are_over_the_wheel(bag, capsys):
    orders = printed(capsys, bag, "--signal", "wheel_1", "--orders")
    assert orders["circumference_m"] == pytest.approx(2.713)
    assert orders["rms"][0] == pytest.approx(98.1e3, rel=0.01)
    mean = printed(capsys, bag, "--signal", "wheel_1", "--average")
    assert mean["turns"] == 3
    angle = mean["angle_rad"][int(np.argmax(mean["mean"]))]
    assert min(angle, 2 * np.pi - angle) < 0.1  # the defect is at angle 0


def test_people_see_a_table(bag, capsys):
    assert main(["spectrum", str(bag), "--signal", "velocity/middle/value", "--third-octave"]) == 0
    assert "level, dB re 1e-09 m/s" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--signal", "wheel_3"], "signal = 'wheel_3' is not a known signal of this bag: did you mean wheel_2"),
        (["--signal", "wheel_1", "--resolution", "-1"], "--resolution = -1 Hz is out of range"),
        (["--signal", "wheel_1", "--out", "a.txt"], "--out a.txt is no table: give a name that ends in .csv"),
    ],
)
def test_what_cannot_be_is_refused(bag, capsys, arguments, words):
    assert main(["spectrum", str(bag), *arguments]) == 2
    assert words in capsys.readouterr().err
