"""``fatigue --ledger`` and ``--mission``: runs that add up, and go on after a crash."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from support.paths import ROOT
from support.toy import toy_simulator
from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.fatigue.ledger import load_ledger
from wheelset_track_sim.live.run_messages import record

STEPS = 6 * 2713


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("ledger") / "run.mcap"
    run = toy_simulator(like="damage_wheel_1")
    with record(path, run) as push:
        while run.next_step < STEPS:
            push(run.advance(min(1389, STEPS - run.next_step)))
    return path


def printed(capsys, *arguments):
    assert main(["fatigue", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_runs_go_into_a_ledger_once(bag, tmp_path, capsys):
    ledger = tmp_path / "axle.ledger"
    keep = (bag, "--angles", "8", "--ledger", ledger, "--axle", "axle 7")
    first = printed(capsys, *keep)
    (run,) = first["axles"]["axle 7"]["runs"]
    assert (run["steps"], run["finished"], run["scenario"]) == (STEPS, True, "damage_wheel_1")
    damage = first["axles"]["axle 7"]["nodes"]["A1"]["damage"]["elementary"]
    assert damage == pytest.approx(first["runs"][0]["nodes"]["A1"]["damage_per_1000_km"]["elementary"] * STEPS * 1e-9)
    content = ledger.read_bytes()
    again = printed(capsys, *keep)
    assert again["warnings"] == [
        f"{bag}: these steps are in the ledger, and are not added again: give --run NAME if it ran again"
    ]
    assert ledger.read_bytes() == content
    twice = printed(capsys, *keep, "--run", "on tuesday")
    assert twice["axles"]["axle 7"]["nodes"]["A1"]["damage"]["elementary"] == 2 * damage
    shown = printed(capsys, ledger)
    assert shown["axles"] == twice["axles"]
    assert printed(capsys, ledger, ledger)["axles"] == twice["axles"]  # merged twice
    merged = printed(capsys, ledger, "--ledger", tmp_path / "all.ledger")
    assert merged["axles"] == twice["axles"]
    assert main(["fatigue", str(ledger)]) == 0
    assert "axle 7, 2 runs" in capsys.readouterr().out


def test_several_runs_add_up_without_a_ledger(bag, capsys):
    part = printed(capsys, bag, bag, "--angles", "8")
    assert len(part["runs"]) == 2
    assert len(part["warnings"]) == 1  # the second is the same run
    assert part["axles"]["axle"]["nodes"]["A1"]["distance_m"] == pytest.approx(STEPS * 1e-3)


@pytest.mark.slow
def test_a_count_that_is_killed_goes_on_without_counting_twice(bag, tmp_path, capsys):
    ledger, whole = tmp_path / "axle.ledger", tmp_path / "whole.ledger"
    arguments = [str(bag), "--angles", "8", "--axle", "7", "--checkpoint", "1 m", "--ledger"]
    printed(capsys, *arguments, whole)
    command = [sys.executable, "-m", "wheelset_track_sim", "fatigue", *arguments, str(ledger)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, env=environment) as process:
        while not ledger.exists():
            assert process.poll() is None
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    (begun,) = load_ledger(ledger).entries
    assert begun.state
    assert begun.steps < STEPS
    found = printed(capsys, *arguments, ledger)
    assert not found["warnings"]
    assert ledger.read_bytes() == whole.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--axle", "7"], "--axle applies to a ledger"),
        (["--ledger", "axle.npz", "--axle", "7"], "give one that ends in .ledger"),
        (["--ledger", "axle.ledger"], "--axle is missing"),
        (["--ledger", "no/axle.ledger", "--axle", "7"], "its folder does not exist"),
        (["--ledger", "axle.ledger", "--axle", "7", "--checkpoint", "0"], "--checkpoint 0 m is out of range"),
        (["--mission", "intercity"], "--mission takes one scenario"),
    ],
)
def test_what_cannot_be_is_refused(bag, tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert main(["fatigue", str(bag), *arguments]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "axle.ledger").exists()


def test_a_mission_is_run_leg_by_leg(tmp_path, capsys):
    path = tmp_path / "mission.yaml"
    path.write_text(
        "title: short\nsample: 10 m\nlegs: [{share: 1, speed: 100 km/h}]\n"
        "growth: [{after: 0}, {after: 1000 km, set: {irregularities.0.h: 0.5 mm}}, {after: 9000 km}]\n"
    )
    arguments = ["damage_wheel_1", "--mission", path, "--angles", "8", "--distance", "2000 km"]
    found = printed(capsys, *arguments)
    node = found["nodes"]["A1"]
    (_, first), (distance, whole) = node["damage_over_distance"]
    assert (found["distance_m"], distance) == (2e6, 2e6)
    assert first < whole < 2 * first  # the shallower breakout damages less
    assert node["damage"]["elementary"] == whole
    assert node["distance_to_damage_1_m"]["original"] is None
    assert main(["fatigue", *map(str, arguments)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "short: damage_wheel_1 over 2,000 km" in shown
    assert "* distance to" in shown
