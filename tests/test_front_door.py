"""The front door: what ``import wheelset_track_sim as wts`` offers, its page, and every example on it."""

import doctest
import inspect
import subprocess
import sys

import pytest

import wheelset_track_sim as wts
from support.paths import ROOT
from tools.api_page import PAGE, page

NAMES = [name for name in wts.__all__ if not name.startswith("_")]
ERRORS = [name for name in NAMES if name.endswith("Error")]
RESULTS = ["Identification", "Prediction", "Resimulation", "WaysideReading"]
"""What functions return: their example has it."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Folder with the bag that examples read: as short as serves."""
    folder = tmp_path_factory.mktemp("examples")
    simulator = wts.Simulator(wts.load_scenario("damage_wheel_1"))
    with wts.record(folder / "ten_seconds.mcap", simulator) as push:
        while simulator.time < 2.6:
            push(simulator.advance(1389))
    return folder


def test_names_are_imported_when_they_are_first_used():
    code = "import sys, wheelset_track_sim as wts; assert 'numpy' not in sys.modules; print(*dir(wts))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert set(NAMES) <= set(found.stdout.split())
    with pytest.raises(AttributeError, match="has no attribute 'simulator'"):
        wts.simulator  # noqa: B018


def test_every_name_has_one_place_and_what_commands_print_can_be_caught():
    assert [*wts._PLACES] == NAMES == sorted(NAMES)
    assert {"InputError", "InputWarning", "WheelsetTrackError"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_documented(name):
    text = inspect.getdoc(getattr(wts, name))
    assert text
    assert text.partition("\n")[0].endswith((".", ":")) or "\n\n" in text
    if name in ERRORS:
        return
    takes = inspect.isfunction(getattr(wts, name)) or name in ("Simulator", "Fleet")
    written = text + (getattr(wts, name).__init__.__doc__ or "") if inspect.isclass(getattr(wts, name)) else text
    assert "Parameters\n----------" in written or not takes
    assert ">>> " in text or name in RESULTS


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name not in (*ERRORS, *RESULTS)])
def test_its_example_holds(name, bag, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ten_seconds.mcap").symlink_to(bag / "ten_seconds.mcap")
    names = {each: getattr(wts, each) for each in NAMES} | {"dataclasses": __import__("dataclasses")}
    [example] = doctest.DocTestFinder(recurse=False).find(getattr(wts, name), name, globs=names)
    printed = []
    results = doctest.DocTestRunner().run(example, out=printed.append)
    assert results.attempted > 0
    assert results.failed == 0, "".join(printed)


def test_the_page_is_made_from_the_docstrings():
    assert PAGE.read_text(encoding="utf-8") == page(), "python -m tools.api_page writes it"
