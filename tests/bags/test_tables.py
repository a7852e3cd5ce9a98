import sys

import numpy as np
import pytest

from wheelset_track_sim.bags import BagWriter, read_bag
from wheelset_track_sim.errors import InputError

START_NS = 1_700_000_000_123_456_789


@pytest.fixture
def recording(tmp_path, run_info, run_blocks):
    with BagWriter(tmp_path / "run.mcap", run_info, start_ns=START_NS) as writer:
        for block in run_blocks:
            writer.write(block)
    return read_bag(tmp_path / "run.mcap")


def test_pandas_has_a_row_for_each_step(recording):
    pytest.importorskip("pandas")
    frame = recording.to_pandas()
    assert len(frame) == len(recording) == 2090
    assert frame.index.name == "time"
    np.testing.assert_array_equal(frame.index, recording.time)
    np.testing.assert_array_equal(frame[["wheel_1", "wheel_2"]], recording.forces)
    np.testing.assert_array_equal(frame["B1_yz"], recording.stresses[:, 1, 5])
    np.testing.assert_array_equal(frame["C1_max_principal"], recording.max_principal[:, 2])
    assert frame["step"].tolist() == [*range(2090)]
    assert set(frame.attrs["units"]) == {"time", *frame.columns}
    assert frame.attrs["units"]["wheel_1"] == "N"
    assert frame.attrs["units"]["A1_xx"] == "Pa"
    assert (frame.attrs["scenario"], frame.attrs["start_ns"]) == ("undamaged", START_NS)


@pytest.mark.slow
def test_xarray_has_names_for_everything(recording):
    pytest.importorskip("xarray")
    data = recording.to_xarray()
    assert dict(data.sizes) == {"time": 2090, "wheel": 2, "node": 3, "component": 6}
    one = data.stress.sel(node="B1", component="yz")
    np.testing.assert_array_equal(one, recording.stresses[:, 1, 5])
    np.testing.assert_array_equal(data.force.sel(wheel="wheel_2"), recording.forces[:, 1])
    assert {name: array.attrs["units"] for name, array in data.data_vars.items()} == {
        "force": "N",
        "stress": "Pa",
        "max_principal": "Pa",
    }
    assert data.position.attrs["units"] == "m"
    window = data.sel(time=slice(0.01, 0.02))
    assert window.time.values[0] >= 0.01
    assert window.time.values[-1] <= 0.02
    assert np.shares_memory(data.force.values, recording.forces)


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_a_missing_library_is_named(recording, monkeypatch, library):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=f"{library} is not installed: pip install {library}"):
        getattr(recording, f"to_{library}")()
