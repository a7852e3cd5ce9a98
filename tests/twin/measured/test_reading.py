"""Text files of measured signals."""

from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.written import Form, forms
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.twin.measured import Reading, read_measurement
from wheelset_track_sim.twin.measured.csv_file import write_csv

ROWS = [f"{0.001 * number:.3f},{98 + number:.1f},{2 * number}" for number in range(20)]
HEAD = "time [s],wheel_1 [kN],A1_yy [MPa]"


def file(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "measured.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_units_are_those_of_the_headings(tmp_path: Path) -> None:
    found = read_measurement(file(tmp_path, "# from the wayside", "", HEAD, *ROWS))
    assert found.axis == "time"
    assert [*found.signals] == ["wheel_1", "A1_yy"]
    np.testing.assert_allclose(found.at, np.arange(20) * 1e-3)
    np.testing.assert_allclose(found.signals["wheel_1"], (98 + np.arange(20)) * 1e3)
    np.testing.assert_allclose(found.signals["A1_yy"], 2e6 * np.arange(20))


@given(form=forms(), axis=st.sampled_from([("time", "ms"), ("position", "mm"), ("t", "s"), ("x", "m")]))
def test_every_form_of_table_is_the_same_measurement(
    tmp_path_factory: pytest.TempPathFactory, form: Form, axis: tuple[str, str]
) -> None:
    rows = [(0.5 * number, 98.0 + number, 60.0 + 0.25 * number) for number in range(16)]
    names, units = (axis[0], "wheel_2", "A1"), (axis[1], "kN", "MPa")
    found = read_measurement(form.write(tmp_path_factory.getbasetemp() / "forces.txt", names, units, rows))
    assert found.axis == ("time" if axis[1] in ("s", "ms") else "position")
    np.testing.assert_allclose(found.at, 0.5 * np.arange(16) * (1e-3 if axis[1] in ("ms", "mm") else 1.0), rtol=1e-15)
    np.testing.assert_array_equal(found.signals["wheel_2"], (98.0 + np.arange(16)) * 1e3)
    np.testing.assert_array_equal(found.signals["A1"], (60.0 + 0.25 * np.arange(16)) * 1e6)


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        (["time,wheel_1 [kN]", "0,1"], "the first column is 'time': give time \\[s\\] or position \\[m\\], or another"),
        (["time [m],wheel_1 [kN]", "0,1"], r"the first column is 'time \[m\]'"),
        (["position [s],wheel_1 [kN]", "0,1"], r"the first column is 'position \[s\]'"),
        (["time [s],wheel_1", "0,1"], r"'wheel_1' has no unit: write wheel_1 \[N\] above it"),
        (["time [s],wheel_1 [MPa]", "0,1"], r"unit of 'wheel_1 \[MPa\]' is not a unit of force: give N, kN"),
        (["time [s],A1 [kN]", "0,1"], r"no signal that can be used in time \[s\], A1 \[kN\]: .*give Pa, kPa, MPa"),
        (["time [s],A1 [Pa],A1 [MPa]", "0,1,1"], "A1 comes twice"),
        ([HEAD, *ROWS[:3], "0.003,1"], "line 5 has 2 cells: give 3"),
        ([HEAD, *ROWS[:3], "0.003,1,"], "line 5: A1_yy has no value"),
        ([HEAD, *ROWS[:3], "# gap", "0.002,1,1"], "line 6: 0.002 is not after the 0.002 before it"),
        ([HEAD, *ROWS[:3], ",1,1"], "line 5: nan is not after the 0.002 before it"),
        ([HEAD, *ROWS[:3]], "has 3 samples of time and of wheel_1, A1_yy: give at least 16 of each"),
    ],
)
def test_what_cannot_be_used_is_refused_by_line(tmp_path: Path, lines: list[str], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        read_measurement(file(tmp_path, *lines))


def test_other_columns_are_left_out_and_named(tmp_path: Path) -> None:
    rows = [f"{row},{number},3" for number, row in enumerate(ROWS)]
    with pytest.warns(InputWarning, match=r"speed \[km/h\], Y_1 \[kN\] is not used"):
        found = read_measurement(file(tmp_path, f"{HEAD},speed [km/h],Y_1 [kN]", *rows))
    assert [*found.signals] == ["wheel_1", "A1_yy"]


def test_columns_and_units_are_given_where_headings_have_others(tmp_path: Path) -> None:
    rows = [f"{number},{98e3 + number},{97e3 + number}" for number in range(20)]
    reading = Reading(units=("ms", "N"), columns={"wheel_1": "Q left", "wheel_2": "3"})
    found = read_measurement(file(tmp_path, "t,Q left,Q right", *rows), reading)
    np.testing.assert_allclose(found.at, np.arange(20) * 1e-3)
    np.testing.assert_array_equal(found.signals["wheel_1"], 98e3 + np.arange(20))
    np.testing.assert_array_equal(found.signals["wheel_2"], 97e3 + np.arange(20))
    with pytest.raises(InputError, match="has no column 'Q middle' for wheel_1: give one of t, Q left, Q right"):
        read_measurement(
            file(tmp_path, "t,Q left,Q right", *rows), Reading(("ms", "N"), columns={"wheel_1": "Q middle"})
        )
    with pytest.raises(InputError, match="--unit 'lb' is not known"):
        Reading(units=("lb",))
    with pytest.raises(InputError, match="--offset applies to wheel_1 or wheel_2, not to 'A1'"):
        Reading(offsets={"A1": 1.0})


def test_time_stamps_keep_their_origin(tmp_path: Path) -> None:
    stamps = [f"{1764500000_002876500 + 100_000 * number}" for number in range(20)]
    found = read_measurement(file(tmp_path, "time [ns],wheel_1 [kN]", *(f"{at},98.{at[-6]}" for at in stamps)))
    assert found.origin == Decimal("1764500000.0028765")
    np.testing.assert_allclose(found.at, 1e-4 * np.arange(20), rtol=1e-12)
    assert found.even


def test_a_file_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv does not exist: give a text file or a bag"):
        read_measurement(tmp_path / "none.csv")


def test_what_cannot_be_finished_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "stress.csv"
    with pytest.raises(ValueError, match="shorter"):
        write_csv(path, "time", np.arange(3.0), {"A1": np.zeros(2)}, "Pa")
    assert not path.exists()


@given(st.lists(st.floats(-1e9, 1e9), min_size=16, max_size=40), st.sampled_from(["time", "position"]))
def test_what_is_written_comes_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, values: list[float], axis: str
) -> None:
    path = tmp_path_factory.mktemp("csv") / "stress.csv"
    at = np.cumsum(np.full(len(values), 1 / 3))
    values[:2] = [1e6, 2e6]  # some stress of an axle
    write_csv(path, axis, at, {"A1": np.array(values)}, "Pa")  # type: ignore[arg-type]
    found = read_measurement(path)
    assert found.axis == axis
    np.testing.assert_array_equal(found.at, at)
    np.testing.assert_array_equal(found.signals["A1"], values)
    with pytest.raises(InputError, match="exists already"):
        write_csv(path, "time", at, {}, "Pa")
