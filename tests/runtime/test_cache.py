import importlib
import logging
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.runtime import cache, sources
from wheelset_track_sim.runtime.progress import Progress


@dataclass(frozen=True)
class Line:
    values: np.ndarray

    def to_arrays(self) -> dict[str, np.ndarray]:
        return {"values": self.values}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> "Line":
        return cls(arrays["values"])


BUILT: list[int] = []
"""Sizes of the lines that were built."""


def line(size: int, progress: Progress | None) -> Line:
    BUILT.append(size)
    return Line(np.arange(float(size)))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path / "cache"))
    BUILT.clear()
    return tmp_path / "cache"


def get() -> Line:
    return cache.cached("line", Line, line, 3)


def test_a_model_is_built_once(folder: Path) -> None:
    assert np.array_equal(get().values, get().values)
    assert BUILT == [3]
    assert [path.name.partition("-")[0] for path in folder.iterdir()] == ["line"]


def test_other_inputs_make_another_model(folder: Path) -> None:
    assert len(get().values) == 3
    assert len(cache.cached("line", Line, line, 4).values) == 4
    assert BUILT == [3, 4]


def test_a_model_is_built_again_when_a_module_is_edited_that_its_builder_imports(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    made = tmp_path / "made_here"
    made.mkdir()
    (made / "__init__.py").touch()
    (made / "line.py").write_text(
        f"from {__name__} import Line\nfrom .size import size\ndef line(progress): return Line(size())"
    )
    sizes = []
    for text in ("def size(): return [1.0]", "def size(): return [1.0, 2.0]"):
        (made / "size.py").write_text(text)
        for name in [name for name in sys.modules if name.startswith("made_here")]:
            monkeypatch.delitem(sys.modules, name)
        importlib.invalidate_caches()
        sources.program.cache_clear()
        build = importlib.import_module("made_here.line").line
        sizes.append(len(cache.cached("made", Line, build).values))
    assert sizes == [1, 2]


def test_a_builder_with_hidden_inputs_is_refused(folder: Path) -> None:
    size = 3
    with pytest.raises(TypeError, match="make it a function of a module"):
        cache.cached("line", Line, lambda progress: line(size, progress))
    with pytest.raises(TypeError, match="make it a function of a module"):
        cache.cached("line", Line, partial(line, 3))
    assert BUILT == []


@pytest.mark.parametrize("damage", [b"", b"not a model", None])
def test_a_damaged_file_is_reported_and_built_again(
    folder: Path, damage: bytes | None, caplog: pytest.LogCaptureFixture
) -> None:
    get()
    [path] = folder.iterdir()
    if damage is None:  # of another layout
        np.savez(path, other=np.zeros(1))
    else:
        path.write_bytes(damage)
    with caplog.at_level(logging.WARNING):
        assert len(get().values) == 3
    assert "built again" in caplog.text
    get()
    assert BUILT == [3, 3]


@pytest.mark.parametrize("values", [np.arange(2.0), np.array([0.0, 1.0, np.nan]), np.array([0.0, 1.0, 3.0])])
def test_a_sound_file_of_other_content_is_reported_and_built_again(
    folder: Path, values: np.ndarray, caplog: pytest.LogCaptureFixture
) -> None:
    get()
    [path] = folder.iterdir()
    with np.load(path) as stored:
        arrays = dict(stored)
    np.savez(path, **(arrays | {"values": values}))
    with caplog.at_level(logging.WARNING):
        assert np.array_equal(get().values, np.arange(3.0))
    assert "built again" in caplog.text


def test_a_folder_that_cannot_be_written_does_not_stop_the_run(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder.write_text("a file where the folder should be")
    with caplog.at_level(logging.WARNING):
        assert len(get().values) == 3
    assert "not cached" in caplog.text


def test_digest_follows_values() -> None:
    inputs = {"a": 0.1, "b": [1, 2], "c": np.ones(2)}
    assert cache.digest(inputs) == cache.digest(dict(reversed(inputs.items())))
    others = [
        {"a": np.nextafter(0.1, 1)},
        {"b": [1, 3]},
        {"c": np.ones(3)},
        {"c": np.ones((2, 1))},
        {"c": np.ones(2, int)},
    ]
    assert len({cache.digest(inputs | other) for other in ({}, *others)}) == 6


def test_of_a_kind_with_a_bound_those_used_last_are_kept(folder: Path) -> None:
    def kept(kind: str) -> list[int]:
        return sorted(len(np.load(path)["values"]) for path in folder.glob(f"{kind}-*.npz"))

    cache.cached("line", Line, line, 9)
    for age, size in enumerate((1, 2, 3, 4)):
        cache.cached("many", Line, line, size)
        newest = max(folder.glob("many-*.npz"), key=lambda path: path.stat().st_mtime_ns)
        os.utime(newest, (age, age))
    size = newest.stat().st_size
    cache.cached("many", Line, line, 1)  # is used again
    cache.cached("many", Line, line, 5, most=3.5 * size)
    assert (kept("line"), kept("many")) == ([9], [1, 4, 5])
    cache.cached("many", Line, line, 6, most=0.5 * size)  # not even the new one fits
    assert (kept("line"), kept("many")) == ([9], [])
