"""CSV files of measured signals."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.twin.measured.csv_file import read_csv, write_csv

ROWS = [f"{0.001 * number:.3f},{98 + number:.1f},{2 * number}" for number in range(20)]
HEAD = "time [s],wheel_1 [kN],A1_yy [MPa]"


def file(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "measured.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_units_are_those_of_the_headings(tmp_path: Path) -> None:
    found = read_csv(file(tmp_path, "# from the wayside", "", HEAD, *ROWS))
    assert found.axis == "time"
    assert [*found.signals] == ["wheel_1", "A1_yy"]
    np.testing.assert_allclose(found.at, np.arange(20) * 1e-3)
    np.testing.assert_allclose(found.signals["wheel_1"], (98 + np.arange(20)) * 1e3)
    np.testing.assert_allclose(found.signals["A1_yy"], 2e6 * np.arange(20))


@pytest.mark.parametrize("separator", [";", "\t"])
def test_other_separators_allow_a_decimal_comma(tmp_path: Path, separator: str) -> None:
    lines = [line.replace(",", separator).replace(".", ",") for line in ROWS]
    found = read_csv(file(tmp_path, separator.join(["position (km)", "Wheel 2 (N)", "B1 (Pa)"]), *lines))
    assert found.axis == "position"
    assert found.at[1] == pytest.approx(1.0)
    assert found.signals["wheel_2"][1] == pytest.approx(99.0)
    assert found.signals["B1"][1] == 2.0


def test_a_byte_order_mark_and_windows_lines_do_not_matter(tmp_path: Path) -> None:
    path = tmp_path / "measured.csv"
    path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join([HEAD, *ROWS]).encode())
    assert len(read_csv(path).at) == 20


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ([], "holds no line"),
        (["time,wheel_1 [kN]"], r"line 1: 'time' is not of the form name \[unit\]"),
        (["x [m],wheel_1 [kN]"], r"line 1: the first column is 'x \[m\]': give time \[s\] or position \[m\]"),
        (["time [m],wheel_1 [kN]"], "the first column is"),
        (["time [s],wheel_1 [MPa]"], r"unit of 'wheel_1 \[MPa\]' is not known here: give N, kN"),
        (["time [s],A1 [kN]"], "give Pa, kPa, MPa"),
        (["time [s],A1 [Pa],A1 [MPa]"], "A1 comes twice"),
        (["time [s]"], "names one column"),
        ([HEAD, *ROWS[:3], "0.003,1"], "line 5 has 2 cells: give 3"),
        ([HEAD, "0,000,98,1,0,0"], r"line 2 has 6 cells: give 3 .* \(decimal commas need semicolons or tabs"),
        ([HEAD.replace(",", ";"), "0.000;98,100;0"], r"line 2: '98,100' has ',' where numbers before it have '\.'"),
        ([HEAD.replace(",", ";"), "0,000;98,1;0", "0.001;98;0"], r"line 3: '0\.001' has '\.' .* before it have ','"),
        ([HEAD, '"' + 200_000 * "x"], "line 2 is no line of cells"),
        ([200_000 * "x"], "line 1 is no line of cells"),
        ([HEAD, *ROWS[:3], "0.003,1,"], "line 5: '' is not a finite number"),
        ([HEAD, *ROWS[:3], "0.003,nan,1"], "line 5: 'nan' is not a finite number"),
        ([HEAD, *ROWS[:3], "# gap", "0.002,1,1"], "line 6: 0.002 is not behind the 0.002 before it"),
        ([HEAD, *ROWS[:3]], "has 3 samples: give at least 16"),
    ],
)
def test_what_cannot_be_used_is_refused_by_line(tmp_path: Path, lines: list[str], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        read_csv(file(tmp_path, *lines) if lines else _empty(tmp_path))


def _empty(tmp_path: Path) -> Path:
    path = tmp_path / "empty.csv"
    path.write_text("")
    return path


def test_files_that_are_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "picture.csv").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="is not text in UTF-8"):
        read_csv(tmp_path / "picture.csv")
    with pytest.raises(InputError, match="cannot be read"):
        read_csv(tmp_path / "missing.csv")


def test_what_cannot_be_finished_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "stress.csv"
    with pytest.raises(ValueError, match="shorter"):
        write_csv(path, "time", np.arange(3.0), {"A1": np.zeros(2)}, "Pa")
    assert not path.exists()


def test_a_large_file_takes_the_room_of_its_numbers(tmp_path: Path) -> None:
    count = 10_000
    path = file(tmp_path, HEAD, *(f"{number}.5,98.123,2.5" for number in range(count)))
    tracemalloc.start()
    try:
        read_csv(path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 5 * 3 * 8 * count + 100_000


@given(st.lists(st.floats(-1e9, 1e9), min_size=16, max_size=40), st.sampled_from(["time", "position"]))
def test_what_is_written_comes_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, values: list[float], axis: str
) -> None:
    path = tmp_path_factory.mktemp("csv") / "stress.csv"
    at = np.cumsum(np.full(len(values), 1 / 3))
    write_csv(path, axis, at, {"A1": np.array(values)}, "Pa")  # type: ignore[arg-type]
    found = read_csv(path)
    assert found.axis == axis
    np.testing.assert_array_equal(found.at, at)
    np.testing.assert_array_equal(found.signals["A1"], values)
    with pytest.raises(InputError, match="exists already"):
        write_csv(path, "time", at, {}, "Pa")
