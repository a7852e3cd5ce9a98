import json

import numpy as np
import pytest

from wheelset_track_sim.dataset.store import ArrayPlan, ChunkStore
from wheelset_track_sim.errors import InputError

PLANS = {
    "signal": ArrayPlan((5, 2, 3), 2, ("sample", "channel", "time"), {"units": "N", "channels": ["a", "b"]}),
    "peak": ArrayPlan((5, 2), 2, ("sample", "wheel"), {}),
}
VALUES = {
    "signal": np.arange(30, dtype=np.float32).reshape(5, 2, 3),
    "peak": np.arange(10, dtype=np.float32).reshape(5, 2),
}


@pytest.fixture
def store(tmp_path):
    store = ChunkStore(tmp_path / "data.zarr", PLANS, {"seed": 1})
    store.begin()
    for chunk in range(3):
        store.save(chunk, {name: values[2 * chunk : 2 * chunk + 2] for name, values in VALUES.items()})
    return store


def test_chunks_are_read_again(store):
    assert np.array_equal(np.concatenate([store.load("signal", chunk) for chunk in range(3)]), VALUES["signal"])
    assert all(store.has(chunk) for chunk in range(3))
    assert not store.has(3)


def test_zarr_reads_what_is_written(store):
    zarr = pytest.importorskip("zarr", minversion="3", reason="the extra analysis brings zarr")
    group = zarr.open_group(store.folder, mode="r")
    assert dict(group.attrs) == {"seed": 1}
    for name, values in VALUES.items():
        assert np.array_equal(group[name][:], values)
        assert dict(group[name].attrs) == dict(PLANS[name].attributes)


def test_xarray_reads_dimensions(store):
    xarray = pytest.importorskip("xarray", reason="the extra analysis brings xarray")
    pytest.importorskip("zarr", minversion="3", reason="the extra analysis brings zarr")
    found = xarray.open_zarr(store.folder)
    assert found.signal.dims == ("sample", "channel", "time")
    assert np.array_equal(found.peak.values, VALUES["peak"])


def test_what_a_killed_program_left_is_removed(store):
    left = store.folder / "signal" / "c" / "tmpx.tmp"
    left.write_bytes(b"half")
    store.begin()
    assert not left.exists()
    assert store.has(2)


def test_the_folder_of_something_else_is_refused(store, tmp_path):
    with pytest.raises(InputError, match=r"data.zarr holds another data set, or one of another version: give another"):
        ChunkStore(store.folder, PLANS, {"seed": 2}).begin()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match="mine is a folder with other files"):
        ChunkStore(tmp_path / "mine", PLANS, {}).begin()
    (store.folder / "zarr.json").write_text("{")
    with pytest.raises(InputError, match=r"data.zarr cannot be used \(.*\): give another folder with --out"):
        store.begin()


def test_missing_values_are_nan(store):
    packed = json.loads((store.folder / "signal" / "zarr.json").read_text())
    assert packed["fill_value"] == "NaN"
