"""The page of input files has every unit, key, option and limit, as the code has them."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.cli.command_line import command_parser
from wheelset_track_sim.contact import orientation, profile_files
from wheelset_track_sim.contact.named_profiles import load_profile
from wheelset_track_sim.inputs.tables import COMMENTS
from wheelset_track_sim.inputs.units import UNITS
from wheelset_track_sim.irregularities import Profile, Roughness, measured, roughness, turns
from wheelset_track_sim.twin.measured import plausibility, read_measurement

TEXT = (ROOT / "docs" / "reference" / "input-files.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", TEXT, re.MULTILINE | re.DOTALL))


def rows(section: str) -> dict[str, str]:
    return dict(re.findall(r"^\| (.*?) \| (.*?) \|$", SECTIONS[section], re.MULTILINE))


def test_units_and_comments_are_all_there() -> None:
    (named,) = re.findall(r"^Units are (.*?)\.$", SECTIONS["Text tables"], re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", named)) == set(UNITS)
    (marks,) = re.findall(r"lines that begin with (.*?)\. \|", SECTIONS["Text tables"])
    assert re.findall(r"`(.*?)`", marks) == [*COMMENTS]


def test_keys_are_all_there() -> None:
    keys = {name.strip("`") for name in rows("Lateral profiles") if name.startswith("`") and name.count("`") == 2}
    assert keys - set(profile_files.SIMPACK) == {field.name for field in dataclasses.fields(profile_files.ProfileFile)}
    for suffix in (*profile_files.MINIPROF, *profile_files.SIMPACK):
        assert f"`{suffix}`" in SECTIONS["Lateral profiles"]
    keys = {name.strip("`") for name in rows("Measured treads and rails") if name.startswith("`")}
    others = {"on", "file", "angle", "start", "ramp", "repeat", "table"}  # which irregularities.md has
    assert keys == {field.name for field in dataclasses.fields(Profile)} - others


def test_options_are_all_there() -> None:
    options = set()
    for command in ("compare", "stress"):
        actions = command_parser()._subparsers._group_actions[0].choices[command]._actions
        options |= {action.option_strings[0] for action in actions if action.option_strings}
    named = set(re.findall(r"`(--\w+)[ `=]", "".join(rows("Measured loads"))))
    assert named == options - {
        "-h",
        "--json",
        "--threshold",
        "--wheelset",
        "--nodes",
        "--speed",
        "--out",
        "--own-weight",
    }


def test_limits_are_those_of_the_code() -> None:
    flat = re.sub(r"\s+", " ", TEXT)
    low, high = plausibility.LOADS
    for words in (
        f"more than {1e3 * orientation.FLANGE:g} mm away from the tread",
        f"outside of y = {1e3 * orientation.TIP[0]:g} to {1e3 * orientation.TIP[1]:g} mm",
        f"more than {1e3 * orientation.OFF_MIDDLE:g} mm from y = 0",
        f"a flange above {1e3 * orientation.HIGHEST:g} mm, or less than {1e3 * orientation.FLATTEST:g} mm from",
        f"field corner is more than {1e3 * orientation.MIRRORED:g} mm lower",
        f"rises by more than {1e3 * orientation.FIELD_RISE:g} mm to the field side",
        f"if they are more than {1e3 * profile_files.DATUM:g} mm there",
        f"more than {1e6 * turns.SMALLEST:g} µm, and five times",
        f"vary by less than {1e6 * measured.SMOOTHEST:g} µm",
        f"within {100 * measured.CLOSING:g} %",
        f"more than {measured.GAP:g} times the usual one",
        f"above {100 * roughness.STEEPEST:g} % of the wavelength",
        f"mean outside of {low / 1e3:g} to {high / 1e3:g} kN",
        f"negative by more than {100 * plausibility.PULL:g} % of its range",
        f"stress above {plausibility.STRESSES[1] / 1e9:g} GPa",
        f"stress below {plausibility.STRESSES[0] / 1e6:g} MPa",
    ):
        assert words in flat, words
    assert (turns.SEAM, turns.MOST, plausibility.AC, roughness.COVERED) == (5.0, 0.9, 0.1, 0.5)  # in words there


@pytest.mark.parametrize("section", ["Roughness spectra", "Measured loads"])
def test_the_files_of_the_page_are_read(tmp_path: Path, section: str) -> None:
    lines = re.findall(r"^    ((?:wavelength|time|[\d,.;]+).*)$", SECTIONS[section], re.MULTILINE)
    path = tmp_path / "file.csv"
    if section == "Roughness spectra":
        path.write_text("\n".join(lines))
        assert Roughness("rail_1", file=str(path)).spectrum == ((0.4, 17.1), (0.0315, -5.0), (0.00315, -11.0))
    else:
        rows = [f"{1e-4 * number},{103 + number % 7},{102 - number % 5},{65 + number % 3}" for number in range(20)]
        path.write_text("\n".join([*lines[:1], *rows]))
        assert [*read_measurement(path).signals] == ["wheel_1", "wheel_2", "A1_yy"]


def test_a_profile_of_the_page_is_read(tmp_path: Path) -> None:
    y = np.arange(-30.0, 31.0)
    path = tmp_path / "rail.csv"
    path.write_text("\n".join(["y_mm,z_mm", *(f"{a},{-a * a / 600}" for a in y)]))
    assert load_profile("rail", {"file": str(path), "turn": "none"}).span == (-0.03, 0.03)
