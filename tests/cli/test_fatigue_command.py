"""``fatigue`` of a bag and of a scenario."""

import dataclasses
import json

import pytest

from support.toy import toy_simulator
from wheelset_track_sim.bags import BagWriter, RunInfo
from wheelset_track_sim.bags.bag import Bag
from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.live.run_messages import record

STEPS = 6 * 2713


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A toy run, and its fatigue computed as it was recorded."""
    path = tmp_path_factory.mktemp("fatigue") / "run.mcap"
    run = toy_simulator(like="damage_wheel_1")
    static = static_stress(run.scenario, run.models.reduced, run.scenario.output.stress_nodes)
    fatigue = AxleFatigue(static, TurningWheel.of(run.scenario), load_curve("assumed_body"))
    with record(path, run) as push:
        while run.next_step < STEPS:
            block = run.advance(min(1389, STEPS - run.next_step))
            push(block)
            fatigue.push(block)
    return path, fatigue


def printed(capsys, *arguments):
    assert main(["fatigue", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_damage_of_a_bag_is_that_of_its_run_bit_by_bit(bag, capsys):
    path, fatigue = bag
    found = printed(capsys, path)
    assert found["run"] == "damage_wheel_1"
    assert found["distance_m"] == pytest.approx(STEPS * 1e-3)
    assert found["curve"]["source"].startswith("assumed")
    assert found["curve"]["assumed"] is True
    assert [*found["nodes"]] == ["A1", "B1", "C1"]
    for node in fatigue.nodes:
        values = found["nodes"][node.name]
        assert values["damage_per_1000_km"]["elementary"] == node.damage_in(1e6)[0]
        assert values["rotating_amplitude_Pa"] == node.amplitude
        assert values["ratio_to_undamaged"]["elementary"] == node.ratios[0] > 1
        assert values["ratio_to_undamaged"]["original"] is None
        assert values["worst_angle_rad"] == node.angle
        assert values["merged_damage_at_most"] < 1e-6 * values["damage_per_1000_km"]["elementary"]


def test_a_part_of_a_bag_another_curve_and_angles(bag, capsys, tmp_path):
    assert main(["init", "woehler", "assumed_body", str(tmp_path / "mine.yaml")]) == 0
    assert "fatigue damage_wheel_1 --curve" in capsys.readouterr().out
    text = (tmp_path / "mine.yaml").read_text().replace("200.0e+6", "100.0e+6")
    (tmp_path / "mine.yaml").write_text(text)
    usual = printed(capsys, bag[0], "--distance", "8 m", "--angles", "12")
    assert (usual["distance_m"], len(usual["angles_rad"])) == (8.0, 12)
    weaker = printed(capsys, bag[0], "--distance", "8 m", "--angles", "12", "--curve", tmp_path / "mine.yaml")
    of_a1 = [each["nodes"]["A1"]["damage_per_1000_km"]["elementary"] for each in (usual, weaker)]
    assert of_a1[1] == pytest.approx(32 * of_a1[0])
    assert weaker["nodes"]["A1"]["ratio_to_undamaged"] == pytest.approx(usual["nodes"]["A1"]["ratio_to_undamaged"])


def test_people_see_what_depends_on_the_curve(bag, capsys):
    assert main(["fatigue", str(bag[0])]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "* damage, ratio to undamaged" in shown
    assert "* damage per 1,000 km, Haibach" in shown
    assert "* by the S-N curve assumed_body: 200 MPa at 1e+06 cycles, slope 5" in shown
    assert "source: assumed: limit of EA1N" in shown


def test_scatter_and_a_criterion_are_further_rows(bag, capsys):
    arguments = "--distance", "8 m", "--angles", "4", "--service", "1e6 km", "--criterion", "assumed_findley"
    found = printed(capsys, bag[0], *arguments)
    assert found["service_m"] == 1e9
    assert found["criterion"]["assumed"] is True
    for node in found["nodes"].values():
        low, high = node["damage_per_1000_km_band"]["elementary"]
        assert low < node["damage_per_1000_km"]["elementary"] < high
        failing = node["failure_probability"]
        assert 1.0 >= failing["elementary"] > failing["haibach"] >= failing["original"] >= 0.0
        assert node["findley_usage"] == pytest.approx(node["rotating_amplitude_Pa"] / 200e6, rel=0.15)
    assert main(["fatigue", str(bag[0]), *arguments]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "* elementary, weak axle (2.5 %)" in shown
    assert "* fail within 1,000,000 km, Haibach" in shown
    assert "* usage by the criterion of Findley assumed_findley: k = 0.157" in shown


@pytest.fixture
def gappy(tmp_path):
    run = toy_simulator()
    with record(tmp_path / "gap.mcap", run) as push:
        push(run.advance(1000))
        run.advance(500)
        push(run.advance(3000))
    return tmp_path / "gap.mcap"


def test_a_bag_with_a_gap_is_refused_by_name(gappy, capsys):
    assert main(["fatigue", str(gappy)]) == 1
    assert "gap.mcap has a gap, step 1500 follows step 999" in capsys.readouterr().err


def test_a_decimated_bag_is_refused_by_name(bag, tmp_path, capsys):
    path = tmp_path / "slow.mcap"
    run = toy_simulator()
    with BagWriter(path, Bag(bag[0]).info, start_ns=0) as writer:
        writer.write_state(Bag(bag[0]).states[0])
        writer.write(dataclasses.replace(run.advance(3000), decimation=10))
    assert main(["fatigue", str(path)]) == 1
    assert "slow.mcap holds only every 10th step of" in capsys.readouterr().err


def test_a_changed_axle_load_is_warned_of(capsys, tmp_path):
    path = tmp_path / "run.mcap"
    run = toy_simulator()
    with record(path, run) as push:
        push(run.advance(3000))
        run.apply(dataclasses.replace(run.scenario, axle_load=150e3))
        while run.next_step < 6000:
            push(run.advance(6000 - run.next_step))
    warnings = printed(capsys, path)["warnings"]
    assert warnings == ["axle_load changes during the run: ratios compare with an undamaged axle under 196.2 kN"]


def test_a_bag_without_a_scenario_is_refused(tmp_path, capsys):
    run = toy_simulator()
    with BagWriter(tmp_path / "bare.mcap", RunInfo("x", "", "", 0.6), start_ns=0) as bag:
        bag.write(run.advance(3000))
    assert main(["fatigue", str(tmp_path / "bare.mcap")]) == 1
    assert "bare.mcap holds no scenario, so its loads are unknown" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--set", "speed=20"], "--set changes a scenario, and a bag is a run already"),
        (["--distance", "0 m"], "--distance 0 m is out of range"),
        (["--distance", "2 m"], "has 2 m, less than one turn of 2.713 m: give more"),
        (["--curve", "steel"], "'steel' is not a known woehler"),
        (["--angles", "3"], "angles = 3 is out of range"),
        (["--gate", "9 MPa"], "gate = 9e+06 Pa is out of range"),
        (["--service", "0 km"], "--service 0 m is out of range"),
        (["--criterion", "mises"], "'mises' is not a known criterion"),
    ],
)
def test_what_cannot_be_is_refused(bag, capsys, arguments, words):
    assert main(["fatigue", str(bag[0]), *arguments]) == 2
    assert words in capsys.readouterr().err
