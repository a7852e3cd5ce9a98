"""``show`` draws what the models have: heights, profiles, supports, section; the gallery has every shipped scenario."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from support.paths import ROOT
from wheelset_track_sim.cli import main
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.report.pictures.scenario import rows_of
from wheelset_track_sim.report.pictures.structures import draw_profiles, draw_supports, uneven
from wheelset_track_sim.report.pictures.surfaces import draw_along, draw_map, irregular_surfaces
from wheelset_track_sim.scenario import load_scenario

DOCS = ROOT / "docs"
TURN = 2713


def axes():
    return Figure().subplots()


def test_only_irregular_surfaces_are_drawn_with_their_heights():
    assert list(irregular_surfaces(load_scenario("undamaged"), TURN)) == []
    scenario = load_scenario("damage_wheel_1", ["irregularities.0.angle=1.5", "irregularities.0.y=0.004"])
    (surface,) = irregular_surfaces(scenario, TURN)
    assert surface.name == "wheel_1"
    deepest = np.unravel_index(surface.heights.argmin(), surface.heights.shape)
    assert surface.heights[deepest] == pytest.approx(-0.002, rel=0.01)
    assert surface.along[deepest[0]] / surface.around * 2 * np.pi == pytest.approx(1.5, abs=1e-3)
    assert surface.y[deepest[1]] == pytest.approx(0.004, abs=1e-3)


def test_an_irregular_tread_is_drawn_by_angle_with_the_deepest_place_beside_it():
    (surface,) = irregular_surfaces(load_scenario("damage_wheel_1", ["irregularities.0.angle=1.5"]), TURN)
    along, around = axes(), axes()
    draw_along(along, surface)
    draw_map(around, surface)
    angle, height = along.lines[0].get_data()
    assert angle[np.argmin(height)] == pytest.approx(np.degrees(1.5), abs=0.2)
    assert height.min() == pytest.approx(-2.0, rel=0.01)
    assert "mm" in along.get_ylabel()
    assert "86°" in around.get_xlabel()
    (image,) = around.images
    assert image.get_array().min() == pytest.approx(-2.0, rel=0.01)


def test_a_rail_is_drawn_along_the_line_in_micrometres_if_it_is_flat():
    surfaces = list(irregular_surfaces(load_scenario("corrugation"), TURN))
    assert {surface.name for surface in surfaces} == {"rail_1"}
    along = axes()
    draw_along(along, surfaces[0])
    assert "µm" in along.get_ylabel()
    assert along.lines[0].get_ydata().max() == pytest.approx(15.0, rel=0.02)


def test_profiles_touch_where_the_contact_is_marked():
    geometry = load_scenario("lateral_offset").geometry
    for wheel in (0, 1):
        drawn = axes()
        draw_profiles(drawn, geometry, wheel)
        rail, tread, contact = (line.get_data() for line in drawn.lines[:3])
        gap = tread[1] - rail[1]
        assert np.nanmin(gap) == pytest.approx(0.0, abs=1e-3)
        assert gap[np.abs(rail[0] - contact[0][0]).argmin()] == pytest.approx(0.0, abs=1e-2)


def test_supports_are_drawn_where_they_differ():
    assert uneven(load_scenario("undamaged").track) == ()
    track = load_scenario("stiffness_transition").track
    assert uneven(track) == ("ballast",)
    drawn = axes()
    draw_supports(drawn, track, "ballast")
    values = drawn.lines[0].get_ydata()
    assert values.max() / values.min() > 2
    assert values[0] == pytest.approx(track.ballast.stiffness / 2 / 1e6)
    hanging = load_scenario("hanging_sleeper").track
    drawn = axes()
    draw_supports(drawn, hanging, "ballast")
    assert any("gap 0.5 mm" in text for text in drawn.get_legend_handles_labels()[1])


def test_the_papers_wheelset_and_track_are_nothing_special():
    assert [row.special for row in rows_of(load_scenario("damage_wheel_1"))] == [True, False, False]


@pytest.mark.slow
def test_the_command_writes_a_picture_and_refuses_in_one_line(tmp_path, capsys):
    out = tmp_path / "picture.png"
    assert main(["show", "damage_both", "--set", "irregularities.0.h=0.001", "--out", str(out)]) == 0
    picture = imread(out)
    assert picture.shape[1] == 1200
    assert np.ptp(picture) > 0.5
    assert main(["show", "damage_both", "--out", str(out / "below.png")]) == 2
    assert main(["show", "no_such_scenario"]) == 2
    assert capsys.readouterr().err.count("\n") >= 2


def test_a_picture_overwrites_no_scenario(tmp_path, capsys):
    mine = tmp_path / "mine.yaml"
    mine.write_text("name: mine\nspeed: 30.0\n", encoding="utf-8")
    assert main(["show", str(mine), "--out", str(mine)]) == 2
    assert "mine.yaml is not a picture: give a name that ends in .png" in capsys.readouterr().err
    assert mine.read_text(encoding="utf-8") == "name: mine\nspeed: 30.0\n"


@pytest.mark.slow
def test_the_gallery_has_every_shipped_scenario_and_every_picture():
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"^### `(\w+)`$", page, re.MULTILINE)
    assert sorted(shown) == sorted(set(shipped.names("scenarios")) - {"undamaged", "line_speeds"})
    for name in shown:
        picture = imread(DOCS / "images" / "gallery" / f"{name}.png")
        assert picture.shape[1] == 1200
