"""Mutated bags with right checksums: every command ends in results or in one line, and "complete" is true."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.records import Metadata

from support.blocks import small_run
from support.mutants import MUTANTS, bounded, mutated_bytes, mutated_trees
from support.rewriting import KINDS, Entry, Kind, entries_of, write
from wheelset_track_sim.bags import Bag, read_bag
from wheelset_track_sim.bags.definitions import deserialise, short_name, typestore
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.errors import WheelsetTrackError
from wheelset_track_sim.inputs.yaml12 import dump, parse
from wheelset_track_sim.report.survey import survey
from wheelset_track_sim.twin.run_inputs import run_inputs

pytestmark = [pytest.mark.fuzz, pytest.mark.slow]
quiet = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=MUTANTS
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


@pytest.fixture(scope="module")
def source(folder: Path) -> tuple[list[Entry], list[Any]]:
    small_run(folder / "source.mcap", chunks=6, length=12)
    return entries_of(folder / "source.mcap")


def use(path: Path, folder: Path) -> None:
    """All that is done with a bag, each by itself."""
    whole = _tried(overview, path)
    strict = _tried(read_bag, path)
    if strict is not None:
        assert (np.diff(strict.steps) == 1).all()
        assert np.isfinite(strict.forces).all()
        assert np.isfinite(strict.stresses).all()
    assert whole is None or not whole.complete or strict is not None
    for operation in (survey, lambda path: read_bag(path, lost=lambda _: None), _play, _inputs):
        _tried(operation, path)
    saved = folder / "saved.mcap"
    assert (_tried(lambda path: recover(path, saved), path) is None) != saved.exists()
    saved.unlink(missing_ok=True)


def _tried(operation: Callable[[Path], Any], path: Path) -> Any:
    """What an operation returns; None if it rejects the bag in an error of ours."""
    try:
        with bounded():
            return operation(path)
    except WheelsetTrackError:
        return None


def _play(path: Path) -> int:
    with RecordedBag(path) as bag:
        return sum(1 for _ in bag.messages(0, 2**62, {*bag.topics}))


def _inputs(path: Path) -> Any:
    return run_inputs(Bag(path))


def _fields(message: Any, path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Ways to all values in a message."""
    found = []
    for name in getattr(message, "__dataclass_fields__", ()):
        value = getattr(message, name)
        found += _fields(value, (*path, name)) if hasattr(value, "__dataclass_fields__") else [(*path, name)]
    return [way for way in found if way[-1] != "__msgtype__"]


@st.composite
def changed_messages(draw: st.DrawFn, entries: list[Entry]) -> list[Entry]:
    """Entries of which one to four have a field of another value that its type can hold, or are moved or missing."""
    found = list(entries)
    for _ in range(draw(st.integers(1, 4))):
        number = draw(st.integers(0, len(found) - 1))
        entry = found[number]
        how = draw(st.sampled_from(["field", "field", "field", "time", "topic", "remove", "double", "bytes"]))
        if how == "field":
            try:
                message = deserialise(short_name(entry.type), entry.data)
            except Exception:  # noqa: BLE001  changed before
                continue
            *path, last = draw(st.sampled_from(_fields(message)))
            place = message
            for name in path:
                place = getattr(place, name)
            object.__setattr__(place, last, _like(draw, getattr(place, last)))
            with suppress(Exception):  # the type cannot hold it
                found[number] = entry._replace(data=bytes(typestore().serialize_cdr(message, entry.type)))
        elif how == "time":
            found[number] = entry._replace(
                time_ns=draw(st.sampled_from([0, 1, 2**62, 2**63 + 5, entry.time_ns + 10**15]))
            )
        elif how == "topic":
            found[number] = entry._replace(
                topic=draw(st.sampled_from(["", "x", "/a b", "\x1b[2J", entry.topic + "/x"]))
            )
        elif how == "remove" and len(found) > 1:
            del found[number]
        elif how == "double":
            found.insert(number, entry)
        else:
            found[number] = entry._replace(data=draw(mutated_bytes(entry.data)))
    return found


def _like(draw: st.DrawFn, value: Any) -> Any:
    """A value of the same kind as another one."""
    if isinstance(value, np.ndarray):
        length = draw(st.sampled_from([0, 1, len(value) - 1, len(value) + 1, len(value)]))
        found = np.resize(value, max(length, 0)).copy() if len(value) else np.zeros(length, value.dtype)
        if len(found) and value.dtype.kind == "f":
            found[draw(st.integers(0, len(found) - 1))] = draw(st.floats())
        return found
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return draw(st.sampled_from([0, 1, 2, 7, 255, 2**31 - 1, 2**32 - 1, 2**63 - 1, 2**64 - 1, -1, -(2**31)]))
    if isinstance(value, float):
        return draw(st.floats())
    if isinstance(value, str):
        content = parse(value, "text") if ": " in value else None
        other = draw(mutated_trees(content)) if isinstance(content, dict) else None
        try:
            return dump(other)
        except Exception:  # noqa: BLE001  no YAML
            return "{a: " * 30
    return draw(st.sampled_from([value[:-1], value + value])) if isinstance(value, list) else value


@quiet
@given(data=st.data(), kind=KINDS)
def test_messages(folder: Path, source: tuple[list[Entry], list[Any]], data: st.DataObject, kind: Kind) -> None:
    entries, records = source
    changed = data.draw(changed_messages(entries))
    use(write(folder / "messages.mcap", changed, records, replace(kind, pace=1)), folder)


@quiet
@given(data=st.data())
def test_records(folder: Path, source: tuple[list[Entry], list[Any]], data: st.DataObject) -> None:
    entries, records = source
    changed = []
    for record in records:
        found = data.draw(mutated_trees(dict(record.metadata)))
        pairs = found.items() if isinstance(found, dict) else [("", found)]
        changed.append(Metadata(record.name, {str(key): str(value)[:10_000] for key, value in pairs}))
    use(write(folder / "records.mcap", entries, changed), folder)


@quiet
@given(data=st.data())
def test_bytes(folder: Path, source: tuple[list[Entry], list[Any]], data: st.DataObject) -> None:
    path = write(folder / "bytes.mcap", *source, Kind(chunk_size=2000))
    path.write_bytes(data.draw(mutated_bytes(path.read_bytes())))
    use(path, folder)


@quiet
@given(data=st.data())
def test_folder_metadata(folder: Path, source: tuple[list[Entry], list[Any]], data: st.DataObject) -> None:
    bag = folder / "bag"
    bag.mkdir(exist_ok=True)
    write(bag / "bag_0.mcap", *source)
    tree = {
        "rosbag2_bagfile_information": {
            "version": 9,
            "storage_identifier": "mcap",
            "relative_file_paths": ["bag_0.mcap"],
            "files": [{"path": "bag_0.mcap", "message_count": len(source[0])}],
            "compression_format": "",
        }
    }
    text = dump(data.draw(mutated_trees(tree))).encode()
    (bag / "metadata.yaml").write_bytes(data.draw(st.one_of(st.just(text), mutated_bytes(text))))
    use(bag, folder)
