"""Pages for people: links lead somewhere, the method's steps and the scenario's keys are what and where they say."""

import dataclasses
import importlib
import re

import pytest

from support.paths import ROOT
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import Scenario, load_scenario, scenario_from
from wheelset_track_sim.simulation.simulator import CHANGEABLE

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
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


def test_the_readme_leads_to_every_page():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for page in PAGES:
        assert page.name == "README.md" or f"]({page.relative_to(ROOT)})" in text, page.name


def test_the_page_of_the_method_names_what_is_there():
    text = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")
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
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
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
    assert set(re.findall(r"`(\w+)`", named)) == set(CHANGEABLE)


def default_of(field):
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()


def test_the_scenario_of_the_page_can_be_used(tmp_path):
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    example = "\n".join(re.findall(r"^    (?!\.venv)(.*)$", text, re.MULTILINE))
    (tmp_path / "mine.yaml").write_text(example, encoding="utf-8")
    assert load_scenario(tmp_path / "mine.yaml", ["irregularities.0.h=0.001"]).irregularities[0].h == 0.001


def test_promises_of_security_name_tests_that_exist() -> None:
    named = re.findall(r"`(tests/[\w/.]+)`", (ROOT / "SECURITY.md").read_text())
    assert len(named) > 10
    assert [path for path in named if not (ROOT / path).exists()] == []
