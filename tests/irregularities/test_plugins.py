"""Kinds of irregularities from other packages: the example package, installed beside this one."""

import json
import os
import subprocess
import sys

import pytest

from support.paths import ROOT
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import kinds, read_irregularities
from wheelset_track_sim.irregularities.listing import listed
from wheelset_track_sim.runtime import sources
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.studies.evaluate import Job

BURN = "{type: wheel_burn, on: rail_1, position: 1.2, length: 0.08}"


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """Folder with the example package, as pip installs it; nothing is fetched."""
    folder = tmp_path_factory.mktemp("site")
    source = tmp_path_factory.mktemp("source") / "irregularity_kind"
    subprocess.run(["cp", "-r", str(ROOT / "examples" / "irregularity_kind"), str(source)], check=True)
    options = ["--no-deps", "--no-index", "--no-build-isolation", "--quiet", "--target", str(folder)]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, str(source)], check=True)
    return folder


@pytest.fixture
def kind(installed, monkeypatch):
    """The example package on the path of this process."""
    monkeypatch.syspath_prepend(str(installed))
    for cached in (kinds._registered, kinds.kind_named):
        cached.cache_clear()
    yield
    monkeypatch.undo()
    for cached in (kinds._registered, kinds.kind_named):
        cached.cache_clear()


@pytest.mark.slow
def test_it_works_in_scenarios_and_changes_and_carries_its_package_in_text(kind):
    scenario = load_scenario("undamaged", [f"irregularities=[{BURN}]", "irregularities.0.width=0.02"])
    [burn] = scenario.irregularities
    assert (burn.type, burn.length, burn.width) == ("wheel_burn", 0.08, 0.02)
    assert scenario.line_steps == 60_000
    [mapping] = scenario.to_mapping()["irregularities"]
    assert (mapping["type"], mapping["package"]) == ("wheel_burn", "wheel-burn")
    assert scenario_from(scenario.to_mapping()) == scenario
    assert listed(f"[{BURN}]", str)[0].length == 0.08  # as a topic or a service gives it
    with pytest.raises(InputError, match=r"^irregularities\.0\.length = 3 m is out of range: give length of the burn"):
        load_scenario("undamaged", [f"irregularities=[{BURN}]", "irregularities.0.length=3"])
    with pytest.raises(InputError, match="did you mean wheel_burn"):
        load_scenario("undamaged", ["irregularities=[{type: wheel_bun}]"])


@pytest.mark.slow
def test_a_result_of_a_study_is_of_one_version_of_the_kind(kind, installed):
    job = Job(load_scenario("undamaged", [f"irregularities=[{BURN}]"]), 0.1, 0.1, ("wheels.wheel_1.max_force",))
    before, source = job.digest(), installed / "wheel_burn.py"
    text = source.read_text()
    source.write_text(f"{text}# edited\n")
    sources.program.cache_clear()
    assert job.digest() != before
    source.write_text(text)
    sources.program.cache_clear()
    assert job.digest() == before


def test_without_the_package_it_is_named():
    scenario = load_scenario("undamaged").to_mapping()
    mapping = {"type": "wheel_burn", "package": "wheel-burn", "on": "rail_1"}
    with pytest.raises(InputError) as refusal:
        scenario_from(scenario | {"irregularities": [mapping]})
    assert str(refusal.value) == (
        "irregularities.0.type = 'wheel_burn' needs the package wheel-burn, which is not installed: install it"
    )


def command(installed, *arguments, status=0):
    """What the command line prints with or without the example package."""
    path = os.pathsep.join(filter(None, [str(installed or ""), str(ROOT), os.environ.get("PYTHONPATH", "")]))
    program = [sys.executable, "-m", "wheelset_track_sim", *map(str, arguments)]
    done = subprocess.run(program, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": path}, timeout=300)
    assert done.returncode == status, done.stderr
    return done.stdout if status == 0 else done.stderr


@pytest.mark.slow
def test_it_works_on_the_command_line_and_in_bags(installed, tmp_path):
    bag = tmp_path / "burn.mcap"
    change = f"irregularities=[{BURN}]"
    options = ["--set", change, "--duration", "0.08", "--out", bag, "--json"]
    found = json.loads(command(installed, "run", "undamaged", *options))
    assert found["wheels"]["wheel_1"]["max_force_N"] > 120e3
    assert found["wheels"]["wheel_2"]["max_force_N"] < 110e3
    again = json.loads(command(installed, "resimulate", bag, "--json"))
    assert again["identical"]
    other = json.loads(command(installed, "resimulate", bag, "--set", "irregularities.0.length=0.04", "--json"))
    assert not other["identical"]
    refusal = command(None, "resimulate", bag, status=1)
    assert "needs the package wheel-burn, which is not installed" in refusal
    assert len(refusal.splitlines()) == 1


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("raise RuntimeError('broken')", r"cannot be imported \(RuntimeError\('broken'\)\)"),
        ("class Odd: pass", "is not a dataclass of that type"),
        ("from dataclasses import dataclass\n@dataclass\nclass Odd:\n    type = 'odd'", "needs a field on"),
    ],
)
def test_a_package_that_registers_something_else_is_named(tmp_path, monkeypatch, source, words):
    (tmp_path / "odd.py").write_text(source)
    about = tmp_path / "odd_kind-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: odd-kind\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[{kinds.GROUP}]\nodd = odd:Odd\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    kinds._registered.cache_clear()
    try:
        with pytest.raises(InputError, match=rf"irregularities\.0\.type = 'odd'.*odd-kind.*{words}|odd-kind {words}"):
            read_irregularities([{"type": "odd", "on": "wheel_1"}], "irregularities")
    finally:
        monkeypatch.undo()
        kinds._registered.cache_clear()
        sys.modules.pop("odd", None)
