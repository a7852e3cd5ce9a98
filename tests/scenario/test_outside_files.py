"""Files from elsewhere, from the file to the peak force: with each of them another number once came without a word."""

import json
from pathlib import Path

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.cli import main

WHEEL = (ROOT / "tests" / "data" / "wheel_profile.csv").read_text()
DATA = [line.split(",") for line in WHEEL.splitlines()[1:]]
DOWNWARDS = "\n".join(["y_mm,z_mm", *(f"{y},{-float(z)}" for y, z in DATA)])
MIRRORED = "\n".join(["y_mm,z_mm", *(f"{-float(y)},{z}" for y, z in DATA)])
TAPE = "\n".join(["y_mm,z_mm", *(f"{float(y) + 70.0},{z}" for y, z in DATA)])
BREAKOUT = "irregularities=[{{type: breakout, on: wheel_1, a: 0.02, b: 0.01, h: 0.0005}}]"
LEANING = ["profiles.inclination=0.05", BREAKOUT]


def tread(heading: str, columns: list[np.ndarray]) -> str:
    return "\n".join([heading, *(",".join(f"{cell:.3f}" for cell in row) for row in zip(*columns, strict=True))])


ANGLE, CLOSED = np.arange(360.0), np.arange(361.0)
WAVES, WAVES_CLOSED = (30.0 * np.cos(np.radians(12.0 * angle)) for angle in (ANGLE, CLOSED))
TREAD = "irregularities=[{{type: profile, on: wheel_1, file: {file}{options}}}]"
ROUGH = "irregularities=[{{type: roughness, on: rail_1, seed: 1, file: {file}}}]"
SPECTRUM = "wavelength [{unit}];level [dB]\n10;14,0\n3,15;5,0\n0,315;-1,0\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "changes", "peaks", "warned"),
    [
        (WHEEL, ["profiles.wheel_1={file}", *LEANING], (148.3, 55.0), ""),
        (DOWNWARDS, ["profiles.wheel_1={file}", *LEANING], (148.3, 55.0), "give turn: z to confirm"),
        (MIRRORED, ["profiles.wheel_1={file}", *LEANING], (148.3, 55.0), "give turn: y to confirm"),
        (MIRRORED, ["profiles.wheel_1={{file: {file}, turn: y}}", *LEANING], (148.3, 55.0), ""),
        (TAPE, ["profiles.wheel_1={{file: {file}, origin: 0.07}}", *LEANING], (148.3, 55.0), ""),
        (tread("angle_deg,dev_um", [ANGLE, WAVES]), [TREAD], (106.8, 89.5), ""),
        (tread("angle_deg,dev_um", [CLOSED, WAVES_CLOSED]), [TREAD], (106.8, 89.5), ""),
        (tread("angle_deg,wheel_1_um,wheel_2_um", [ANGLE, WAVES, 0 * WAVES]), [TREAD], (106.8, 89.5), ""),
        (tread("angle_deg,dev_um", [ANGLE, WAVES + ANGLE / 3.6]), [TREAD], (None, None), "give drift: remove"),
        (
            tread("angle_deg,dev_um", [ANGLE, WAVES + ANGLE / 3.6]),
            [TREAD.replace("{options}", ", drift: remove")],
            (106.8, 89.5),
            "",
        ),
        (SPECTRUM.format(unit="cm"), [ROUGH, "line_length=10.0"], (110.2, 83.5), "from 0.1 to 0.5 m"),
    ],
)
def test_the_peak_force_is_the_right_one(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    text: str,
    changes: list[str],
    peaks: tuple[float | None, float | None],
    warned: str,
) -> None:
    path = tmp_path / "file.txt"
    path.write_text(text)
    given = [argument for change in changes for argument in ("--set", change.format(file=path, options=""))]
    assert main(["run", "undamaged", *given, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["warnings"]) == bool(warned)
    assert not warned or warned in found["warnings"][0]
    for name, peak in zip(("max_force_N", "min_force_N"), peaks, strict=True):
        assert peak is None or found["wheels"]["wheel_1"][name] == pytest.approx(1e3 * peak, abs=80.0)


def test_a_spectrum_in_cm_without_a_unit_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spectrum = "[[10, 14.0], [3.15, 5.0], [0.315, -1.0]]"
    change = f"irregularities=[{{type: roughness, on: rail_1, seed: 1, spectrum: {spectrum}}}]"
    assert main(["run", "undamaged", "--set", change]) == 2
    told = capsys.readouterr().err
    assert "irregularities.0: spectrum covers wavelengths from 0.315 to 10 m" in told
    assert "give wavelengths in m, if these are in cm" in told
    assert len(told.splitlines()) == 1


def test_rails_from_top_and_from_foot_are_touched_at_one_place(tmp_path: Path) -> None:
    from wheelset_track_sim.scenario import load_scenario

    text = (ROOT / "tests" / "data" / "rail_profile.csv").read_text().splitlines()
    foot = tmp_path / "rail_from_foot.csv"
    foot.write_text("\n".join([text[0], *(f"{y},{float(z) + 172.0}" for y, z in (row.split(",") for row in text[1:]))]))
    touched = [
        load_scenario("undamaged", [f"profiles.rail_1={path}", "profiles.inclination=0.025"]).geometry.touch(0)
        for path in (ROOT / "tests" / "data" / "rail_profile.csv", foot)
    ]
    assert touched[1] == pytest.approx(touched[0], abs=2e-5)
    assert touched[0] == pytest.approx(-0.0075, abs=1e-4)  # 300 mm of crown leaning by 1/40
