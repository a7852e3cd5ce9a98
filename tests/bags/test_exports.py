"""Runs as CSV, Excel, Parquet and NetCDF."""

import csv
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.bags import BagWriter, read_bag
from wheelset_track_sim.bags.exports import FORMS, MOST_ROWS, check_steps, export, exported, form_of
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.twin.measured import read_measurement


@pytest.fixture
def recording(tmp_path, run_info, run_blocks):
    with BagWriter(tmp_path / "run.mcap", run_info, start_ns=1_700_000_000_123_456_789) as writer:
        for block in run_blocks:
            writer.write(block)
    return read_bag(tmp_path / "run.mcap", steps=(0, 300), nodes=["A1"])


def written(recording, path):
    form = form_of(path)
    assert form is not None
    export(recording, path, form)
    assert [each.name for each in path.parent.iterdir() if ".part" in each.name] == []
    return path


def test_csv_keeps_every_bit_and_is_read_as_a_measurement(recording, tmp_path):
    path = written(recording, tmp_path / "run.csv")
    with path.open(encoding="utf-8", newline="") as file:
        heading, *rows = csv.reader(file)
    assert heading[:7] == ["time [s]", "step", "position [m]", "speed [m/s]", "revision", "wheel_1 [N]", "wheel_2 [N]"]
    assert heading[7:] == [f"A1_{name} [Pa]" for name in ("xx", "yy", "zz", "xy", "xz", "yz", "max_principal")]
    assert len(rows) == len(recording)
    np.testing.assert_array_equal([float(row[0]) for row in rows], recording.time)
    np.testing.assert_array_equal([[float(cell) for cell in row[5:7]] for row in rows], recording.forces)
    with pytest.warns(InputWarning, match=r"step, position \[m\], speed \[m/s\], revision is not used"):
        found = read_measurement(path)
    np.testing.assert_array_equal(found.signals["wheel_1"], recording.forces[:, 0])


@pytest.mark.slow
def test_excel_has_headings_and_where_the_run_is_from(recording, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(written(recording, tmp_path / "run.xlsx"), read_only=True)
    heading, *rows = book["run"].iter_rows(values_only=True)
    assert heading[5] == "wheel_1 [N]"
    np.testing.assert_allclose([row[5] for row in rows], recording.forces[:, 0], rtol=1e-15)
    assert dict(book["about"].iter_rows(values_only=True))["scenario"] == "undamaged"


@pytest.mark.slow
def test_parquet_is_the_frame_with_its_units(recording, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    found = pandas.read_parquet(written(recording, tmp_path / "run.parquet"))
    pandas.testing.assert_frame_equal(found, recording.to_pandas())
    assert found.attrs["units"]["wheel_1"] == "N"


@pytest.mark.slow
def test_netcdf_is_the_data_set_with_its_units(recording, tmp_path):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(written(recording, tmp_path / "run.nc"), engine="scipy") as found:
        np.testing.assert_array_equal(found.force, recording.forces)
        np.testing.assert_array_equal(found.stress, recording.stresses)
        assert found.force.attrs["units"] == "N"
        assert found.attrs["scenario"] == "undamaged"
        assert [str(name) for name in found.wheel.values] == ["wheel_1", "wheel_2"]


@pytest.mark.parametrize("name", ["run", "run.mcap", "run.MCAP"])
def test_bags_are_no_tables(name: str, tmp_path: Path) -> None:
    assert form_of(tmp_path / name) is None


@pytest.mark.parametrize("name", ["run.txt", "run.csv.gz", "run.mcap.bak", "run.db3"])
def test_other_suffixes_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"is not a supported format: give a name that ends in .mcap, .csv, .parquet, .xls"
    ):
        form_of(tmp_path / name)


@pytest.mark.parametrize(
    ("suffix", "library"), [(".parquet", "pandas"), (".parquet", "pyarrow"), (".xlsx", "openpyxl"), (".nc", "xarray")]
)
def test_a_missing_library_is_named_with_its_extra(
    suffix: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for each in FORMS[suffix].needs:
        monkeypatch.setitem(sys.modules, each, pytest if each != library else None)
    with pytest.raises(InputError, match=f"needs {library}, which is not installed: .* with the extra analysis"):
        form_of(tmp_path / f"run{suffix}")


def test_nothing_is_replaced_and_nothing_left_behind(recording, tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"run.csv exists already: give another path"):
        form_of(path)
    with pytest.raises(InputError, match=r"run.csv exists already: give another path"):
        export(recording, path, FORMS[".csv"])
    assert path.read_text(encoding="utf-8") == "mine"
    with suppress(KeyboardInterrupt), exported(tmp_path / "new.csv", FORMS[".csv"]) as bag:
        bag.write_bytes(b"half a run")
        raise KeyboardInterrupt
    assert sorted(each.name for each in tmp_path.iterdir()) == ["run.csv", "run.mcap"]


def test_a_sheet_has_an_end() -> None:
    check_steps(Path("run.xlsx"), FORMS[".xlsx"], MOST_ROWS)
    with pytest.raises(
        InputError, match=r"would have 1048576 rows, and .xlsx files hold at most 1048575: give .csv, .parquet"
    ):
        check_steps(Path("run.xlsx"), FORMS[".xlsx"], MOST_ROWS + 1)
