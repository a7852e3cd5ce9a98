"""One reader for all text tables."""

import os
import tracemalloc
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.written import Form, forms
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.tables import read_table
from wheelset_track_sim.wheelset.kinds import load_wheelset

NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)


@given(
    form=forms(),
    rows=st.lists(st.tuples(st.floats(0.0, 1e6), NUMBERS, NUMBERS), min_size=1, max_size=30),
    names=st.sampled_from([("angle", "wheel_1", "wheel_2"), ("winkel", "Rad links", "Rad rechts")]),
    units=st.sampled_from([("deg", "um", "um"), ("mm", "um", "kN")]),
)
def test_the_form_of_a_file_does_not_matter(
    tmp_path_factory: pytest.TempPathFactory,
    form: Form,
    rows: list[tuple[float, ...]],
    names: tuple[str, ...],
    units: tuple[str, ...],
) -> None:
    if form.separator == " ":
        names = tuple(name.replace(" ", "_") for name in names)
    path = form.write(tmp_path_factory.getbasetemp() / "table.txt", names, units, rows)
    table = read_table(path)
    assert [column.name for column in table.columns] == [*names]
    assert [column.unit for column in table.columns] == [*units]
    np.testing.assert_array_equal(np.column_stack([column.values for column in table.columns]), np.array(rows))


def table(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "table.csv"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


def test_columns_without_names_have_none(tmp_path: Path) -> None:
    found = read_table(table(tmp_path, "a title of words", "1 2", "3 4"))
    assert [(column.name, column.unit) for column in found.columns] == [("", ""), ("", "")]
    assert found.find("2") is found.columns[1]
    assert found.find("z") is None


def test_units_alone_are_no_names(tmp_path: Path) -> None:
    found = read_table(table(tmp_path, "[MeasurementData]", "[mm] [µm]", "0\t30,0\t", "1\t29,5\t"))
    assert [(column.name, column.unit) for column in found.columns] == [("", "mm"), ("", "um")]
    np.testing.assert_array_equal(found.columns[1].values, [30.0, 29.5])


def test_empty_cells_have_no_value(tmp_path: Path) -> None:
    found = read_table(table(tmp_path, "a,b,c", "1,,3", "4,nan,", "7,8,9"))
    np.testing.assert_array_equal(np.isnan(found.columns[1].values), [True, True, False])
    np.testing.assert_array_equal(np.isnan(found.columns[2].values), [False, True, False])


@given(
    seconds=st.integers(10**9, 4 * 10**9),
    parts=st.lists(st.integers(0, 10**9 - 1), min_size=2, max_size=20, unique=True).map(sorted),
    stamp=st.sampled_from(["s", "ms", "us", "ns", "iso", "iso+02:00"]),
)
def test_time_stamps_are_exact(
    tmp_path_factory: pytest.TempPathFactory, seconds: int, parts: list[int], stamp: str
) -> None:
    def written(part: int) -> str:
        digits = {"s": 9, "ms": 6, "us": 3, "ns": 0}
        if stamp in digits:
            whole, fraction = divmod(seconds * 10**9 + part, 10 ** digits[stamp])
            return f"{whole}.{fraction:0{digits[stamp]}d}" if digits[stamp] else str(whole)
        zone = stamp.removeprefix("iso")
        moment = np.datetime64(seconds + (7200 if zone else 0), "s")
        return f"{moment}.{part:09d}{zone or 'Z'}"

    path = tmp_path_factory.getbasetemp() / "stamps.csv"
    unit = f" [{stamp}]" if len(stamp) <= 2 else ""
    path.write_text(f"time{unit},wheel_1 [kN]\n" + "".join(f"{written(part)},98\n" for part in parts))
    [time, _] = read_table(path).columns
    size = {"ms": 10**6, "us": 10**3, "ns": 1}.get(stamp, 10**9)
    assert time.unit == (stamp if len(stamp) <= 2 else "s")
    assert time.origin == (seconds * 10**9 + parts[0]) // size
    exact = [(seconds * 10**9 + part - time.origin * size) / size for part in parts]
    np.testing.assert_allclose(time.values, exact, rtol=1e-15)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "holds no numbers: give a line of names with units"),
        (["a,b"], "holds no numbers"),
        (["a,b", "x,y"], "line 2: 'x' is not a number"),
        (["a,b", "1,two"], "line 2: 'two' is not a number"),
        (["a,b", "0.0,abc", "1,2", "3,4"], "line 2: 'abc' is not a number"),
        (["a,b", "1,2", "x,y"], "line 3: 'x' is not a number: correct it, leave the line out, or put #"),
        (["a,b", "1,2", "1,2,3"], "line 3 has 3 cells: give 2 as in the lines before"),
        (["a,b", "0,000,1,0"], r"line 1 has 2 cells, and the row of numbers below has 4: .*\(decimal commas need"),
        (["a;b", "0.5;98,100"], r"line 2: '98,100' has ',' where numbers before it have '\.'"),
        (["a;b", "0,5;98,1", "1.0;2"], r"line 3: '1\.0' has '\.' where numbers before it have ','"),
        (["a;b", "1;2", "1;1,234,567"], "line 3: '1,234,567' is not a number"),
        (["a,b", "1,2", "1,inf"], "line 3: inf is not finite"),
        (["a,b", "1,2", "1,1_000"], "line 3: '1_000' is not a number"),
        (["a,b", "1,2", '"' + 200_000 * "x"], "line 3 has 1 cells"),
        (["30.11.2025 10:53;1", "30.11.2025 10:54;2"], "'30.11.2025 10:54' is not a number.*2025-11-30T10:53:20.5Z"),
        (["2025-13-30T10:53:20;1"], "'2025-13-30T10:53:20' is not a number"),
        (["time [s],b", "-1e40060,3"], "line 2: -inf is not finite"),
        (["time [s],b", "1e9,3", "1e999999999,3"], r"line 3: '1e999999999' is no time: give a number below 1e\+30"),
        (["time [s],b", "1e9,3", "snan,3"], "line 3: 'snan' is no time"),
    ],
)
def test_what_is_no_table_is_refused_by_line(tmp_path: Path, lines: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words) as refusal:
        read_table(table(tmp_path, *lines))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (bytes(range(256)), "is not text"),
        (b"\xff\xfe\x00", "is not text"),
        (b"a,b\n1,\x81\n", "is not text"),  # a byte that Windows-1252 does not have
        (b"\x93NUMPY", "is not text"),
    ],
)
def test_what_is_no_text_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "picture.csv"
    path.write_bytes(content)
    if content[0] == 0x93:
        path.write_bytes(content + bytes(20))
    with pytest.raises(InputError, match=words):
        read_table(path)


def test_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_table(tmp_path / "missing.csv")
    with pytest.raises(InputError, match="is a folder: give a regular file"):
        read_table(tmp_path)
    os.mkfifo(tmp_path / "pipe.csv")  # opening it would wait for a writer
    for endless in (tmp_path / "pipe.csv", Path("/dev/zero")):
        with pytest.raises(InputError, match="is a device or a pipe: give a regular file"):
            read_table(endless)
    with pytest.raises(InputError, match="has 8 bytes: give at most 4"):
        read_table(table(tmp_path, "1,2", "3,4"), largest=4)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((9, 2), complex), "2 dimensions of complex128"),
        (np.zeros(9), "1 dimensions of float64: give real numbers in two dimensions"),
        (np.full((9, 2), np.inf), "not finite"),
    ],
)
def test_arrays_that_are_no_table_are_refused(tmp_path: Path, array: np.ndarray, words: str) -> None:
    np.save(tmp_path / "array.npy", array)
    with pytest.raises(InputError, match=words):
        read_table(tmp_path / "array.npy")


def test_a_file_that_is_no_array_is_refused(tmp_path: Path) -> None:
    (tmp_path / "broken.npy").write_bytes(b"no array")
    with pytest.raises(InputError, match="is not a NumPy file"):
        read_table(tmp_path / "broken.npy")


@pytest.mark.parametrize("shape", ["(1000000000000, 2)", "(10000000000000000000000, 2)", "(-1, 2)", "('", "(2,"])
@pytest.mark.parametrize("suffix", ["npy", "npz"])
def test_the_head_of_an_array_is_not_believed(tmp_path: Path, suffix: str, shape: str) -> None:
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    content = b"\x93NUMPY\x01\x00\x76\x00" + head.encode() + bytes(32)
    path = tmp_path / f"array.{suffix}"
    path.write_bytes(content)
    if suffix == "npz":
        with ZipFile(path, "w") as packed:
            packed.writestr("a.npy", content)
    with pytest.raises(InputError, match=r"is not a NumPy file|cannot be read"):
        read_table(path) if suffix == "npy" else load_wheelset(path)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"zeros": np.zeros(10**8 + 1, "i1")}, "unpacks to 1000001[0-9]+ bytes: give at most 100000000"),
        ({"zeros": np.zeros(2_000_001, "i1")}, "zeros has 2000001 numbers: give at most 2000000"),
        ({"a": np.zeros(3), "a.b": np.zeros(3)}, "a.b is within a, which is an array"),
    ],
)
def test_arrays_unpack_to_a_bounded_size(tmp_path: Path, arrays: dict[str, np.ndarray], words: str) -> None:
    np.savez_compressed(tmp_path / "bomb.npz", allow_pickle=False, **arrays)
    with pytest.raises(InputError, match=words):
        load_wheelset(tmp_path / "bomb.npz")


def test_members_of_an_archive_are_arrays(tmp_path: Path) -> None:
    with ZipFile(tmp_path / "text.npz", "w") as packed:
        packed.writestr("modes", "text")
    with pytest.raises(InputError, match=r"text.npz: modes is no array"):
        load_wheelset(tmp_path / "text.npz")


@pytest.mark.parametrize("name", ["a\0b.csv", "\ud800.csv", "x" * 5000, "a\0b.npy"])
def test_names_that_no_file_can_have_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"cannot be the name of a file|cannot be read"):
        read_table(Path(name))


def test_units_are_asked_for_and_not_contradicted(tmp_path: Path) -> None:
    found = read_table(table(tmp_path, "y,z [mm],F [kN]", "1,2,3"))
    y, z, force = found.columns
    assert found.size(z, "length") == 1e-3
    assert found.size(y, "length", "um") == 1e-6
    with pytest.raises(InputError, match=r"'y' has no unit: write y \[m\] above it"):
        found.size(y, "length")
    with pytest.raises(InputError, match=r"'z \[mm\]' in mm, but you gave m"):
        found.size(z, "length", "m")
    with pytest.raises(InputError, match=r"unit of 'F \[kN\]' is not a unit of length: give m, mm"):
        found.size(force, "length")
    with pytest.raises(InputError, match=r"no column 'x' for the heights: give one of y, z \[mm\], F \[kN\]"):
        found.chosen("x", "the heights")


def test_a_large_file_takes_the_room_of_its_numbers(tmp_path: Path) -> None:
    count = 10_000
    path = table(tmp_path, "a,b,c", *(f"{number}.5,98.123,2.5" for number in range(count)))
    tracemalloc.start()
    try:
        read_table(path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 5 * 3 * 8 * count + 200_000
