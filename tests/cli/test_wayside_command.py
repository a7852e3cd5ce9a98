"""``wayside`` of a bag and of a scenario."""

import csv
import json

import pytest

from support.toy import toy_simulator
from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.wayside.watch import WaysideWatch

STEPS = 5600
STANDING = "wayside=[{detector: shear_single, position: 2.4}, {detector: shear_single, position: 4.2, name: second}]"


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A toy run with two detectors, and what they read as it was recorded."""
    path = tmp_path_factory.mktemp("wayside") / "run.mcap"
    run = toy_simulator(STANDING, like="damage_wheel_1")
    watch = WaysideWatch(run.scenario.wayside, run.scenario.track, 1e-3)
    passed = []
    with record(path, run) as push:
        while run.next_step < STEPS:
            block = run.advance(min(1389, STEPS - run.next_step))
            push(block)
            passed += watch.push(block)
    return path, passed


def printed(capsys, *arguments):
    assert main(["wayside", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def refused(capsys, *arguments):
    assert main(["wayside", *map(str, arguments)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    return line


def test_detectors_of_a_bag_read_what_they_read_live_bit_by_bit(bag, capsys):
    path, passed = bag
    found = printed(capsys, path)
    assert found["run"] == str(path)
    assert found["warnings"] == []
    assert [(each["name"], each["rail"]) for each in found["detectors"]] == [
        (name, rail) for name in ("shear_single", "second") for rail in ("rail_1", "rail_2")
    ]
    verdicts = [verdict for passage in passed for verdict in passage.verdicts]
    for entry, verdict in zip(found["detectors"], verdicts, strict=True):
        assert (entry["mean_N"], entry["peak_N"]) == (verdict.read.mean, verdict.read.peak)
        assert (entry["true_mean_N"], entry["true_peak_N"]) == (verdict.true.mean, verdict.true.peak)
        assert entry["dynamic_factor"] == verdict.read.dynamic_factor
        [channel] = entry["channels"]
        assert (channel["type"], channel["unit"]) == ("shear_bridge", "N")
        assert channel["position_m"] == entry["position_m"] + 0.3


def test_another_detector_elsewhere_and_its_samples_as_a_table(bag, capsys, tmp_path):
    assert main(["init", "detector", "shear_single", str(tmp_path / "mine.yaml")]) == 0
    assert "wayside damage_wheel_1 --detector" in capsys.readouterr().out
    (tmp_path / "mine.yaml").write_text((tmp_path / "mine.yaml").read_text().replace("shear_single", "mine"))
    out = tmp_path / "samples.csv"
    found = printed(capsys, bag[0], "--detector", tmp_path / "mine.yaml", "--at", "3 m", "--out", out)
    assert [(each["name"], each["position_m"]) for each in found["detectors"]] == [("mine", 3.0)] * 2
    with out.open(newline="") as file:
        rows = list(csv.DictReader(file))
    values = [float(row["value"]) for row in rows if row["channel"] == "bay_1_rail_1"]
    assert max(values) == found["detectors"][0]["channels"][0]["max"]
    assert {row["unit"] for row in rows} == {"N"}
    assert "exists already" in refused(capsys, bag[0], "--out", out)


def test_the_table_has_truth_and_reading_side_by_side(bag, capsys, tmp_path):
    assert main(["wayside", str(bag[0]), "--out", str(tmp_path / "run.png")]) == 0
    text = capsys.readouterr().out
    for words in ("shear_single at 2.4 m: wheelset at 100 km/h", "wheel 1, true", "wheel 2, read", "dynamic factor"):
        assert words in text
    assert (tmp_path / "run.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--at", "60 m"), "is off the line of"),
        (("--at", "-1 m"), "--at -1 m is out of range: give 0 to 100000 m"),
        (("--detector", "scale"), "'scale' is not a known detector"),
        (("--detector", "accelerometers", "--at", "2 m"), "beside a sleeper: give"),
        (("--set", "speed=30"), "--set changes a scenario, and a bag is a run already"),
        (("--out", "x.txt"), "is neither a table nor a picture"),
    ],
)
def test_what_cannot_be_read_is_refused(bag, capsys, arguments, message):
    assert message in refused(capsys, bag[0], *arguments)


def test_a_scenario_whose_supports_differ_is_refused_by_name(capsys):
    assert "track.line makes them differ" in refused(capsys, "scattered_support")
