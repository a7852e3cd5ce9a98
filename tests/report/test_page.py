"""What the page says, without a browser."""

import dataclasses
import errno
import io
import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from support.surveys import state
from support.toy import toy_simulator
from wheelset_track_sim.bags import BagWriter, RunInfo
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.report.files import write_whole
from wheelset_track_sim.report.survey import survey_of
from wheelset_track_sim.report.table import description, summary_table
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.verdict.limit_set import load_limits


class Page(HTMLParser):
    """Text outside of scripts; checks that every element is closed."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.stack: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.text: list[str] = []
        self.feed(html)
        self.close()
        assert self.stack == []

    def handle_starttag(self, tag, attrs):
        self.attributes += attrs
        if tag not in ("meta", "link", "br"):
            self.stack.append(tag)

    def handle_endtag(self, tag):
        assert self.stack.pop() == tag

    def handle_data(self, data):
        if not {"script", "style"} & set(self.stack):
            self.text.append(data)

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


@pytest.fixture
def page_of(make_survey, write_report, tmp_path):
    def page(*arguments, **options):
        run = make_survey(*arguments, **options)
        return Page(write_report(run, tmp_path / "new" / "page.html").read_text(encoding="utf-8"))

    return page


@pytest.mark.slow
def test_it_says_what_ran_and_what_came_out(page_of):
    words = page_of("damage_wheel_1", spikes=[(1.8, 300e3)]).words
    for part in (
        "100 km/h, axle load 20 t",
        "300.0 kN",
        "358 kN",
        "Dynamic factor wheel 1 3.06",
        "1 impact, a contact force above 200 kN",
        "Contact pressure at the worst impact",
        "Irregularities of treads and rails throughout the run: breakout on wheel_1: longitudinal semi-axis 30 mm, "
        "lateral semi-axis 24 mm, depth 2 mm, angle 0°",
        "Every step is drawn.",
        "Power spectral density at 100 km/h",
        "digest",
        "numba",
    ):
        assert part in words
    assert re.search(r"peak pressure \d{4} MPa", words)
    assert "2.6 GPa" not in words


def test_it_says_where_steel_would_yield(page_of):
    words = page_of("flat_fresh", spikes=[(1.826, 290e3)]).words
    assert re.search(r"Pressure above 2\.6 GPa on \d\d % of the force\. .*Linear elastic", words)


def test_addresses_of_other_files_or_places_are_not_in_it(page_of):
    attributes = page_of().attributes
    addresses = [value for key, value in attributes if key in ("src", "href", "srcset", "action")]
    assert addresses == ["data:,"]
    policy = next(value for key, value in attributes if key == "content" and "default-src" in value)
    assert policy.startswith("default-src 'none'")


def test_without_impacts(page_of):
    words = page_of("undamaged").words
    assert "There is no impact: at no time was there a contact force above 200 kN." in words
    assert "Contact pressure at the largest force" in words


@pytest.mark.slow
def test_many_impacts(page_of):
    spikes = [(0.5 + 0.15 * number, 201e3 + 1e3 * number) for number in range(150)]
    words = page_of("damage_both", length=25.0, spikes=spikes).words
    assert "150 impacts, each a contact force above 200 kN. The 100 strongest are listed." in words
    assert "250.0 kN" not in words
    assert "251.0 kN" in words


@pytest.mark.slow
def test_changes_are_listed(page_of):
    changes = [(3000, ["speed=30"]), (4000, ["speed=30", "axle_load=150000", "irregularities=[]"])]
    words = page_of("damage_wheel_1", revisions=changes).words
    assert "run.mcap: damage_wheel_1, 2 changes during the run" in words
    assert "100 to 108 km/h, axle load 15.29 to 20 t" in words
    assert "Irregularities of treads and rails changed during the run: the revisions" in words
    assert "0 0 0.0000 s 100 km/h 100 km/h 196.2 kN breakout on wheel_1: longitudinal semi-axis 30 mm" in words
    assert "1 3000 0.1080 s 108 km/h 108 km/h 196.2 kN as in revision 0" in words
    assert "2 4000 0.1413 s 108 km/h 108 km/h 150 kN none" in words


def listed_in(words):
    return words.partition("irregularities of treads and rails 0 0 0.0000 s")[2].partition(" bag run.mcap")[0]


@pytest.mark.parametrize("scenario", ["flat_fresh", "mixed", "polygon", "measured_tread", "squat", "dipped_weld"])
def test_every_irregularity_in_force_is_listed(page_of, scenario):
    """Of any kind, on wheels and rails: a safety department reads the page."""
    given = load_scenario(scenario).to_mapping()["irregularities"]
    words = page_of("undamaged", revisions=[(3000, [f"irregularities={json.dumps(given)}"])]).words
    before, _, after = listed_in(words).partition("1 3000 0.1080 s")
    assert before.split("kN ")[1].strip() == "none"
    for item in given:
        assert f"{item['type']} on {item['on']}: " in after
    assert after.count(" on wheel_") + after.count(" on rail_") == len(given)
    assert "undamaged, 1 change during the run" in words


def test_the_speeds_are_those_that_were_driven(page_of):
    """A set point that is being approached is no speed of the run."""
    braking = "speed_plan=[{time: 0.05, speed: 10}]"
    what = load_scenario("undamaged", [braking])
    run = dataclasses.replace(state(what, 0, 0.0, 0), speed_set_point=10.0)
    block = SampleBlock(0, 0.0, 1e-3 / 25, 25.0, 0.0, 0, np.full((3000, 2), 1e5), np.zeros((3000, 1, 6)), ("A1",))
    found = survey_of([run, block], RunInfo("undamaged", what.to_yaml(), what.digest, 0.6), 0, Path("run.mcap"))
    assert (found.in_force[0].speeds, found.in_force[0].set_point) == ((25.0, 25.0), 10.0)
    assert description(found).startswith("90 km/h")


def test_a_bag_that_does_not_say_what_was_in_force_has_a_page_that_says_so(page_of):
    assert "treads and rails throughout the run: unknown: the bag does not hold them" in page_of(known=False).words


def test_a_bag_of_an_unknown_scenario(page_of):
    words = page_of(known=False, spikes=[(3.0, 300e3)]).words
    assert "impacts are not looked for" in words
    assert "300.0 kN" in words
    assert "Contact pressure" not in words


def test_a_run_too_short_for_a_spectrum(page_of):
    assert "Spectra" not in page_of(length=0.1).words


def test_names_are_shown_and_never_run(page_of):
    name = "</script><script>alert(1)</script>"
    page = page_of(name=name)
    assert name in page.words


def test_a_path_that_cannot_be_written(make_survey, write_report, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_report(make_survey(length=2.7), tmp_path / "file" / "out.html")


def test_a_page_that_cannot_be_finished_leaves_the_old_one(tmp_path, monkeypatch):
    page = write_whole(tmp_path / "new" / "page.html", b"old")

    def full(path, content):
        with path.open("wb") as file:
            file.write(content[:2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"page.html cannot be written \(No space left on device\): give another path"):
        write_whole(page, b"another")
    assert page.read_bytes() == b"old"
    assert [*page.parent.iterdir()] == [page]


@pytest.mark.parametrize("name", ["run.mcap", "page.png", "page"])
def test_a_report_goes_into_a_page_and_nowhere_else(make_bag, tmp_path, capsys, name):
    bag = make_bag(tmp_path / "run.mcap", "undamaged", 1.0, ())
    content = bag.read_bytes()
    assert main(["report", str(bag), "--out", str(tmp_path / name)]) == 2
    assert f"{name} is not a page: give a name that ends in .html" in capsys.readouterr().err
    assert bag.read_bytes() == content
    assert [*tmp_path.iterdir()] == [bag]


@pytest.mark.slow
def test_a_page_is_beside_its_bag_wherever_one_stands(make_bag, tmp_path, monkeypatch):
    bag = make_bag(tmp_path / "run.1", "undamaged", 1.0, ())
    monkeypatch.chdir(bag)
    assert main(["report", "."]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"run.1", "run.1.html", "run.1.png"}


@pytest.mark.parametrize("command", ["info", "report", "recover"])
def test_names_from_a_bag_are_shown_as_they_are(tmp_path, run_info, run_blocks, make_state, capsys, command):
    """What looks like the markup of a terminal or a formula is neither."""
    name = r"bogie [/b] $\bogie$ :train:"
    info = dataclasses.replace(run_info, scenario_name=name)
    bag = tmp_path / "run[old].mcap"
    with BagWriter(bag, info, start_ns=0) as writer:
        writer.write_state(dataclasses.replace(make_state(run_blocks[0]), scenario_name=name))
        writer.write(run_blocks[0])
    assert main([command, str(bag)]) == 0
    out = capsys.readouterr().out
    assert "run[old]" in out
    assert name in out or command == "recover"


def test_a_run_without_stress_nodes_has_a_report_too(tmp_path, run_info, make_block, capsys):
    bag = tmp_path / "run.mcap"
    with BagWriter(bag, run_info, start_ns=0) as writer:
        writer.write(make_block(0, 1389, nodes=()))
    assert main(["report", str(bag)]) == 0
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "contact force (kN)" in page
    assert 'id="spectrum-plots"' in page
    assert "principal stress" not in page


@pytest.mark.slow
def test_a_long_run_makes_a_small_page(make_survey, write_report, tmp_path):
    spikes = [(1.8 + 2.713 * turn, 250e3 + 100.0 * turn) for turn in range(400)]
    run = make_survey("damage_wheel_1", length=1200.0, spikes=spikes)
    assert write_report(run, tmp_path / "page.html").stat().st_size < 7e6
    assert len(run.impacts) == 400


def test_without_bokeh_there_is_one_line(make_bag, tmp_path, monkeypatch, capsys):
    bag = make_bag(tmp_path / "run.mcap", "undamaged", 1.0, ())
    monkeypatch.delitem(sys.modules, "wheelset_track_sim.report.page")
    monkeypatch.setitem(sys.modules, "bokeh", None)
    monkeypatch.setitem(sys.modules, "bokeh.embed", None)
    assert main(["report", str(bag)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "the page needs bokeh, which is not installed: run make setup, or pip install bokeh" in line


@pytest.mark.slow
def test_report_of_a_bag(make_bag, tmp_path, capsys):
    bag = make_bag(tmp_path / "run.mcap", "damage_wheel_1", 6.0, [(1.8, 300e3), (4.513, 290e3)])
    out = tmp_path / "page.html"
    assert main(["report", str(bag), "--out", str(out), "--threshold", "295e3"]) == 0
    assert "1 impact, a contact force above 295 kN" in Page(out.read_text()).words
    assert "page.html" in capsys.readouterr().out
    assert out.with_suffix(".png").exists()
    assert main(["report", str(bag), "--threshold", "-1"]) == 2
    assert "threshold = -1 N is out of range" in capsys.readouterr().err


def test_limits_are_lines_and_a_verdict(make_survey, write_report, tmp_path):
    run = make_survey("damage_wheel_1", length=12.0, spikes=[(1.8, 360e3), (4.5, 210e3)])
    page = write_report(run, tmp_path / "plain.html").read_text(encoding="utf-8")
    assert 'id="verdict"' not in page
    run = dataclasses.replace(run, limits=load_limits("trafikverket"))
    page = write_report(run, tmp_path / "page.html").read_text(encoding="utf-8")
    assert '<span id="verdict">alarm, by trafikverket</span>' in page
    assert "is above 350 kN: stop the train for a visual inspection (trafikverket)" in page
    assert "research.chalmers.se/en/publication/544204" in page
    assert "alarm 350 kN, as far as forces reach them" in page
    assert "never with the largest principal stress" in page
    shown = Console(width=100, file=io.StringIO())
    shown.print(summary_table(run))
    assert "alarm, by trafikverket" in shown.file.getvalue()


def test_fatigue_is_a_section_with_three_plots(make_survey, write_report, tmp_path):
    simulator = toy_simulator(like="damage_wheel_1")
    static = static_stress(simulator.scenario, simulator.models.reduced, ("A1", "B1", "C1"))
    found = AxleFatigue(static, TurningWheel.of(simulator.scenario), load_curve("assumed_body"), points=12)
    for _ in range(3):
        found.push(simulator.advance(2713))
    run = make_survey("damage_wheel_1", length=12.0)
    page = write_report(run, tmp_path / "page.html", None, found).read_text(encoding="utf-8")
    assert 'id="fatigue-plots"' in page
    assert f"<td>{found.nodes[0].ratios[0]:.2f}</td>" in page
    assert "These constants are assumed." in page
    assert "range of rotating stress at" in page
