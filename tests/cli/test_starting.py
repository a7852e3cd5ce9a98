"""Ways in: what is shipped, copies to edit, examples of each command, completion by a shell."""

import argparse
import json
import os
import shlex
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from wheelset_track_sim.cli import command_line, main
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.findley import load_findley
from wheelset_track_sim.fatigue.growth import load_crack_growth
from wheelset_track_sim.fatigue.mission import load_mission
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.studies import load_study
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.verdict.limit_set import load_limits
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.vehicle import load_vehicle

LOADS = {
    "cracks": load_crack_growth,
    "limits": load_limits,
    "missions": load_mission,
    "criteria": load_findley,
    "scenarios": load_scenario,
    "studies": load_study,
    "tracks": load_track,
    "vehicles": load_vehicle,
    "wheelsets": load_wheelset,
    "woehler": load_curve,
}
PARSER = command_line.command_parser()
(PARSERS,) = (action.choices for action in PARSER._actions if isinstance(action, argparse._SubParsersAction))
BIG = ("imported", "trailer_calculix", "mixed", "rail_roughness", "worn_profiles", "scattered_support")


def examples(name: str) -> list[str]:
    """Lines that the help of a command gives as examples."""
    heading, *lines = PARSERS[name].epilog.splitlines()
    assert heading == "examples:"
    return [line.strip() for line in lines]


def test_all_kinds_are_listed_with_a_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {*found} >= {*LOADS}
    for kind, rows in found.items():
        assert [row["name"] for row in rows] == shipped.names(kind)
        for row in rows:
            assert 10 < len(row["description"]) < 220
            assert "\n" not in row["description"]
    assert {"name": "flats", "description": "Wheel flats by length"} in found["studies"]


@pytest.mark.parametrize("kind", ["scenario", "scenarios"])
def test_one_kind_is_listed_in_80_columns(
    kind: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list", kind]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert any("A fresh wheel flat, 60 mm long" in line for line in lines)
    assert not any("x40" in line for line in lines)


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        pytest.param(kind, name, marks=[pytest.mark.slow] if name in BIG else [])
        for kind in LOADS
        for name in shipped.names(kind)
    ],
)
def test_what_is_copied_loads(kind: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "mine.yaml"
    assert main(["init", shipped.singular(kind), name, str(copy)]) == 0
    assert f"{shipped.singular(kind)} {copy}: edit it, then wheelset-track-sim " in capsys.readouterr().out
    load = LOADS[kind]
    assert load(copy) == load(name)  # type: ignore[operator]


@pytest.mark.parametrize("name", shipped.names("wheelsets"))
def test_every_wheelset_has_the_node_that_the_advice_names(name: str) -> None:
    assert "A1" in {node.name for node in load_wheelset(name).stress_nodes}


def test_a_copy_has_the_name_of_what_is_copied_and_replaces_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["init", "track", "slab_60e1"]) == 0
    mine = tmp_path / "slab_60e1.yaml"
    mine.write_text("mine", encoding="utf-8")
    assert main(["init", "track", "slab_60e1"]) == 2
    assert "slab_60e1.yaml exists already: give another path, or --overwrite" in capsys.readouterr().err
    assert mine.read_text(encoding="utf-8") == "mine"
    assert main(["init", "track", "slab_60e1", "--overwrite"]) == 0
    assert mine.read_text(encoding="utf-8") == shipped.text("tracks", "slab_60e1")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["init", "scenaro", "mixed"], "'scenaro' is not a known kind of shipped file: did you mean scenario?"),
        (["init", "scenario", "mixd"], "'mixd' is not a known shipped scenario: did you mean mixed?"),
        (["init", "scenario", "mixed", "nowhere/mine.yaml"], "its folder does not exist"),
        (["init", "scenario", "../scenarios/mixed"], "is not a known shipped scenario"),
        (["list", "bags"], "'bags' is not a known kind of shipped file"),
    ],
)
def test_bad_names_are_refused_in_one_line(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", sorted({*PARSERS} - {"node"}))
def test_each_command_has_examples_that_it_takes(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([name, "--help"])
    lines = examples(name)
    assert len(lines) > 1
    assert capsys.readouterr().out.splitlines()[-len(lines) :] == [f"  {line}" for line in lines]
    for line in lines:
        _, *given = shlex.split(line)
        own, _ = command_line._split(given)
        options = PARSER.parse_args(own)
        for change in getattr(options, "set", None) or ():
            assert change.partition("=")[0] in line
        known = shipped.names("scenarios") + shipped.names("studies")
        for shown in (getattr(options, "scenario", None), getattr(options, "study", None)):
            assert shown is None or shown in known or shown.startswith("mine")


def test_changes_of_the_examples_can_be_used() -> None:
    for line in examples("run"):
        arguments = shlex.split(line)
        changes = [value for option, value in pairwise(arguments) if option == "--set"]
        load_scenario("flat_fresh", changes)


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("wheelset-track-sim res", ["resimulate"]),
        ("wheelset-track-sim run flat_", ["flat_fresh", "flat_rounded"]),
        ("wheelset-track-sim init veh", ["vehicle"]),
        ("wheelset-track-sim init vehicle c", ["coach"]),
        ("wheelset-track-sim run mixed --dur", ["--duration"]),
    ],
)
def test_shells_complete_commands_options_and_names(line: str, found: list[str], tmp_path: Path) -> None:
    answers = tmp_path / "answers"
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_IFS": "\n"}
    asked |= {"_ARGCOMPLETE_STDOUT_FILENAME": str(answers), "COMP_TYPE": "9"}
    code = "import sys; from wheelset_track_sim.cli import main; sys.exit(main())"
    subprocess.run([sys.executable, "-c", code], env=os.environ | asked, check=True, cwd=tmp_path, timeout=60)
    assert [each.strip() for each in answers.read_text(encoding="utf-8").split("\n") if each.strip()] == found
