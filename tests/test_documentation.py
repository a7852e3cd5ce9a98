"""Pages for people: links lead somewhere, the method's steps and the scenario's keys are what and where they say."""

import dataclasses
import importlib
import json
import re
import shlex
from contextlib import suppress
from importlib.util import find_spec

import pytest

import wheelset_track_sim as wts
from support.paths import ROOT
from wheelset_track_sim.cli import main
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import Event, Scenario, load_scenario, scenario_from
from wheelset_track_sim.simulation.simulator import CHANGEABLE

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "examples" / "README.md"])
README = (ROOT / "README.md").read_text(encoding="utf-8")
FOLDERS = {path.parent.name for path in (ROOT / "wheelset_track_sim").glob("*/__init__.py")}


def anchors(page):
    """Names of a page's headings, as in links."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\((?!https?:)([^)\s]+)\)", page.read_text(encoding="utf-8")):
        name, _, anchor = link.partition("#")
        there = page.parent / name if name else page
        assert there.exists(), link
        assert not anchor or anchor in anchors(there), link


def test_readme_and_index_lead_to_every_page():
    first = [ROOT / "README.md", ROOT / "docs" / "index.md"]
    linked = {
        (page.parent / name).resolve() for page in first for name in re.findall(r"\]\(([^)#\s]+)", page.read_text())
    }
    assert set(PAGES) - linked == set()


def test_readme_is_short():
    assert len(README.splitlines()) <= 150


@pytest.mark.slow
def test_python_of_the_readme_prints_what_it_shows(capsys):
    [(code, printed)] = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", README, re.DOTALL)
    exec(code, {})
    assert capsys.readouterr().out == printed


def commands_of(page, begin):
    """Lines of a page's indented blocks that begin with a command, as words."""
    lines = re.findall(rf"^    {re.escape(begin)} (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return [shlex.split(line, comments=True) for line in lines]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_their_options_exist(page, capsys):
    for command, *arguments in commands_of(page, ".venv/bin/wheelset-track-sim"):
        if command == "COMMAND" or (command in ("node", "replay") and find_spec("rclpy") is None):
            continue
        with suppress(SystemExit):
            assert main([command, "--help"]) == 0
        known = set(re.findall(r"--[\w-]+", capsys.readouterr().out))
        own = arguments[: arguments.index("--ros-args")] if "--ros-args" in arguments else arguments
        assert {each for each in own if each.startswith("--")} <= known | {"--help"}, command
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert {target for target, *_ in commands_of(page, "make")} <= targets
    for program, *_ in commands_of(page, ".venv/bin/python"):
        saved = f"`{program}`" in page.read_text(encoding="utf-8")
        assert program.startswith("-") or saved or (ROOT / program).exists(), program
    for package, file, *_ in commands_of(page, "ros2 launch"):
        assert package == "wheelset_track_sim"
        assert (ROOT / "launch" / file).exists(), file


def test_the_page_of_the_node_has_every_command_as_ros2_runs_it(capsys):
    page = (ROOT / "docs" / "howto" / "node.md").read_text()
    section = page.partition("## In a workspace\n")[2].partition("\n## ")[0]
    shown = re.findall(r"^    ros2 run wheelset_track_sim wheelset-track-sim ([a-z]+)", section, re.MULTILINE)
    with suppress(SystemExit):
        main(["--help"])
    assert {*shown} == set(re.findall(r"^    ([a-z]+)(?:\s|$)", capsys.readouterr().out, re.MULTILINE))


def test_the_page_of_the_method_names_what_is_there():
    text = (ROOT / "docs" / "theory" / "method.md").read_text(encoding="utf-8")
    steps, _, parts = text.partition("## Parts of the package")
    named = re.findall(r"`([a-z]\w*(?:\.\w+)+)`", steps)
    assert len(named) > 20
    for name in named:
        module, _, item = name.rpartition(".")
        if (ROOT / "wheelset_track_sim" / f"{name.replace('.', '/')}.py").exists():
            importlib.import_module(f"wheelset_track_sim.{name}")
        else:
            assert hasattr(importlib.import_module(f"wheelset_track_sim.{module}"), item), name
    rows = re.findall(r"^\| (`.*`) \|", parts, re.MULTILINE)
    assert {name for row in rows for name in re.findall(r"`(\w+)`", row)} == FOLDERS


def test_the_page_of_scenarios_has_every_key_with_its_range_and_default():
    text = (ROOT / "docs" / "reference" / "scenarios.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*)\|$", text, re.MULTILINE))
    assert [*sorted(rows)] == sorted(field.name for field in dataclasses.fields(Scenario))
    for field in dataclasses.fields(Scenario):
        unit, span, default, _ = (cell.strip() for cell in rows[field.name].split(" |"))
        declared = field.metadata.get("quantity")
        if declared:
            assert (unit, span) == (declared.unit, f"{declared.low:g} to {declared.high:g}"), field.name
        if default:
            given = {"name": "mine", "speed": 30.0, "axle_load": 2e5, field.name: parse(default.strip("`"), field.name)}
            assert getattr(scenario_from(given), field.name) == default_of(field), field.name
        else:
            assert default_of(field) is dataclasses.MISSING, field.name
    (named,) = re.findall(r"^Only (.*?)\bcan change", text, re.MULTILINE | re.DOTALL)
    assert set(re.findall(r"`(\w+)`", named)) == {*CHANGEABLE, "sensors"}


def test_the_page_of_scenarios_has_every_key_of_an_event_with_its_range():
    text = (ROOT / "docs" / "reference" / "scenarios.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `events\.(\w+)` \|(.*)\|$", text, re.MULTILINE))
    assert [*rows] == [field.name for field in dataclasses.fields(Event)]
    for field in dataclasses.fields(Event):
        declared = field.metadata.get("quantity")
        unit, span, _ = (cell.strip() for cell in rows[field.name].split(" |"))
        wanted = (declared.unit, f"{declared.low:g} to {declared.high:g}") if declared else ("", "")
        assert (unit, span) == wanted, field.name


def default_of(field):
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()


@pytest.mark.slow
def test_the_tutorial_of_the_detector_finds_its_force(tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs" / "tutorials" / "detector.md").read_text(encoding="utf-8")
    (wagon,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "wagon.yaml").write_text(wagon)
    assert main(["identify", "--force", "250 kN", "--scenario", "results/wagon.yaml", "--kind", "flat", "--json"]) == 0
    length = json.loads(capsys.readouterr().out)["kinds"][0]["parameters"]["length_m"]
    shown = re.search(r"fresh flat \| length \| ([\d.]+) mm \| ([\d.]+) mm \| ([\d.]+) mm", text).groups()
    assert [f"{1e3 * length[name]:.1f}" for name in ("estimate", "low", "high")] == [*shown]
    turn = wts.Simulator(wts.load_scenario("results/wagon.yaml")).advance(3000)
    assert 230e3 < turn.forces[:, 0].max() < 250e3 < 350e3
    capsys.readouterr()
    assert main(["fatigue", "results/wagon.yaml", "--json"]) == 0
    a2 = json.loads(capsys.readouterr().out)["nodes"]["A2"]
    assert a2["rotating_amplitude_Pa"] == pytest.approx(81.0e6, abs=0.1e6)
    assert a2["ratio_to_undamaged"]["elementary"] == pytest.approx(2.03, abs=0.005)


def test_the_scenario_of_the_page_can_be_used(tmp_path):
    text = (ROOT / "docs" / "reference" / "scenarios.md").read_text(encoding="utf-8")
    example = "\n".join(re.findall(r"^    (?!\.venv)(.*)$", text, re.MULTILINE))
    (tmp_path / "mine.yaml").write_text(example, encoding="utf-8")
    assert load_scenario(tmp_path / "mine.yaml", ["irregularities.0.h=0.001"]).irregularities[0].h == 0.001


def test_promises_of_security_name_tests_that_exist() -> None:
    named = re.findall(r"`(tests/[\w/.]+)`", (ROOT / "SECURITY.md").read_text())
    assert len(named) > 10
    assert [path for path in named if not (ROOT / path).exists()] == []
