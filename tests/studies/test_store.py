import logging

import numpy as np
import pytest

from wheelset_track_sim.errors import WheelsetTrackError
from wheelset_track_sim.studies.evaluate import Result
from wheelset_track_sim.studies.store import Store

RESULT = Result({"wheels.wheel_1.max_force": 1 / 3}, {"forces": np.arange(6.0).reshape(3, 2) / 7})


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "runs")


def test_a_result_comes_back_bit_by_bit(store) -> None:
    assert store.load("key") is None
    store.save("key", RESULT, "a run")
    found = store.load("key")
    assert found.values == RESULT.values
    assert found.arrays.keys() == {"forces"}
    assert (found.arrays["forces"] == RESULT.arrays["forces"]).all()
    assert [path.name for path in store.folder.iterdir()] == ["key.npz"]


def cut(content):
    return content[: len(content) // 2]


def flipped(content):
    middle = content.index(b"forces.npy") + 60
    return content[:middle] + bytes([content[middle] ^ 0xFF]) + content[middle + 1 :]


@pytest.mark.parametrize("damage", [cut, flipped, lambda content: b"", lambda content: b"nonsense"])
def test_damaged_results_are_reported_and_count_as_none(store, damage, caplog) -> None:
    store.save("key", RESULT, "a run")
    path = store.folder / "key.npz"
    path.write_bytes(damage(path.read_bytes()))
    with caplog.at_level(logging.WARNING):
        assert store.load("key") is None
    assert "key.npz cannot be read" in caplog.text
    assert "the run is done again" in caplog.text
    store.save("key", RESULT, "a run")
    assert store.load("key").values == RESULT.values


def test_what_a_killed_program_left_is_removed(store) -> None:
    store.save("key", RESULT, "a run")
    (store.folder / "half.tmp").write_bytes(b"PK")
    store.tidy()
    assert [path.name for path in store.folder.iterdir()] == ["key.npz"]


def test_a_folder_that_cannot_be_written_is_told(tmp_path) -> None:
    (tmp_path / "runs").write_text("in the way")
    with pytest.raises(WheelsetTrackError, match=r"key.npz cannot be written \(File exists\)"):
        Store(tmp_path / "runs").save("key", RESULT, "a run")
