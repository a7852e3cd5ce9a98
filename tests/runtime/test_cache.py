import logging
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from wheelset_track_sim import errors
from wheelset_track_sim.inputs import schema
from wheelset_track_sim.runtime import cache


@dataclass(frozen=True)
class Line:
    values: np.ndarray

    def to_arrays(self) -> dict[str, np.ndarray]:
        return {"values": self.values}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> "Line":
        return cls(arrays["values"])


@pytest.fixture
def builds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path / "cache"))
    counted = SimpleNamespace(count=0, folder=tmp_path / "cache")

    def build() -> Line:
        counted.count += 1
        return Line(np.arange(3.0))

    counted.get = lambda: cache.cached("line", Line, "key", build)
    return counted


def test_a_model_is_built_once(builds: SimpleNamespace) -> None:
    assert np.array_equal(builds.get().values, builds.get().values)
    assert builds.count == 1
    assert [path.name for path in builds.folder.iterdir()] == ["line-key.npz"]


@pytest.mark.parametrize("damage", [b"", b"not a model", None])
def test_a_damaged_file_is_reported_and_built_again(
    builds: SimpleNamespace, damage: bytes | None, caplog: pytest.LogCaptureFixture
) -> None:
    builds.get()
    path = builds.folder / "line-key.npz"
    if damage is None:  # of another layout
        np.savez(path, other=np.zeros(1))
    else:
        path.write_bytes(damage)
    with caplog.at_level(logging.WARNING):
        assert len(builds.get().values) == 3
    assert "built again" in caplog.text
    builds.get()
    assert builds.count == 2


def test_a_folder_that_cannot_be_written_does_not_stop_the_run(
    builds: SimpleNamespace, caplog: pytest.LogCaptureFixture
) -> None:
    builds.folder.write_text("a file where the folder should be")
    with caplog.at_level(logging.WARNING):
        assert len(builds.get().values) == 3
    assert "not cached" in caplog.text


def test_digest_follows_values_and_sources() -> None:
    inputs = {"a": 0.1, "b": [1, 2], "c": np.ones(2)}
    assert cache.digest(inputs, schema) == cache.digest(dict(reversed(inputs.items())), schema)
    assert cache.digest(inputs, schema) != cache.digest(inputs, errors)
    assert cache.digest(inputs) != cache.digest(inputs | {"a": np.nextafter(0.1, 1)})


def test_of_a_kind_with_a_bound_those_used_last_are_kept(builds: SimpleNamespace) -> None:
    def get(key: str, kind: str = "many", most: float = math.inf) -> None:
        cache.cached(kind, Line, key, lambda: Line(np.arange(3.0)), most=most)

    get("other", kind="line")
    for age, key in enumerate("abcd"):
        get(key)
        os.utime(builds.folder / f"many-{key}.npz", (age, age))
    size = (builds.folder / "many-a.npz").stat().st_size
    get("a")  # is used again
    get("e", most=3.5 * size)
    assert sorted(path.name[:-4] for path in builds.folder.iterdir()) == ["line-other", "many-a", "many-d", "many-e"]
    get("f", most=0.5 * size)  # not even the new one fits
    assert [path.name for path in builds.folder.iterdir()] == ["line-other.npz"]
