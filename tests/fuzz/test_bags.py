"""Mutated bags with right checksums: every command ends in results or in one line, and what it says is true."""

import contextlib
import dataclasses
import io
import json
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
from support.mcap_records import changed_records
from support.mutants import MUTANTS, bounded, mutated_bytes, mutated_trees
from support.plain_signals import FORCES, STRESS, PlainSignals
from support.rewriting import KINDS, Entry, Kind, entries_of, write
from support.toy import toy_scenario
from wheelset_track_sim.bags import Bag, read_bag
from wheelset_track_sim.bags.definitions import deserialise, short_name, typestore
from wheelset_track_sim.bags.overview import Overview, overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.playback.selection import Selection
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.cli import main
from wheelset_track_sim.cli.command_line import PROGRAM
from wheelset_track_sim.errors import InputError, WheelsetTrackError
from wheelset_track_sim.inputs.yaml12 import dump, parse
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.report.survey import survey
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin import resimulate
from wheelset_track_sim.twin.run_inputs import run_inputs

pytestmark = [
    pytest.mark.fuzz,
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::wheelset_track_sim.errors.InputWarning"),
    pytest.mark.filterwarnings("ignore:Generating overly large repr"),  # of a failure, which it would hide
]
quiet = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=MUTANTS
)
STEPS = 10_000
"""Steps without samples that are simulated at most: more of them only take time."""
OF_MODELS = ("wheelset", "track", "vehicle", "profiles", "step_length", "max_frequency", "lag_zero", "dynamics")
"""Scenario keys whose models take seconds to build, as they may."""
COMMANDS = (
    ("info", "BAG"),
    ("info", "--json", "BAG"),
    ("resimulate", "BAG", "--most-steps", str(STEPS)),
    ("resimulate", "--json", "BAG", "--most-steps", str(STEPS)),
    ("recover", "BAG", "--out", "NEW.mcap"),
    ("compare", "BAG", "BAG"),
    ("compare", "--json", "SOURCE", "BAG"),
    ("stress", "BAG", "--out", "NEW.csv"),
    ("report", "BAG", "--out", "NEW.html"),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


@pytest.fixture(scope="module")
def source(folder: Path) -> tuple[list[Entry], list[Any]]:
    """A run of plain numbers."""
    small_run(folder / "source.mcap", chunks=6, length=12)
    return entries_of(folder / "source.mcap")


@pytest.fixture(scope="module")
def simulated(folder: Path) -> tuple[list[Entry], list[Any]]:
    """A run that can be simulated again, with a change in it."""
    simulator = Simulator(toy_scenario())
    with record(folder / "simulated.mcap", simulator) as push:
        for number in range(6):
            if number == 2:
                simulator.apply(dataclasses.replace(simulator.scenario, axle_load=190e3))
            push(simulator.advance(12))
    return entries_of(folder / "simulated.mcap")


def use(path: Path, folder: Path) -> None:
    """All that is done with a bag, each by itself."""
    whole = _tried(overview, path)
    strict = _tried(read_bag, path)
    if strict is not None:
        assert (np.diff(strict.steps) == 1).all()
        assert np.isfinite(strict.forces).all()
        assert np.isfinite(strict.stresses).all()
    if whole is not None and whole.complete:
        assert_complete(whole, path)
    for operation in (survey, lambda path: read_bag(path, lost=lambda _: None), _play, _inputs):
        _tried(operation, path)
    saved = folder / "saved.mcap"
    assert (_tried(lambda path: recover(path, saved), path) is None) != saved.exists()
    saved.unlink(missing_ok=True)


def assert_complete(whole: Overview, path: Path) -> None:
    """A bag that is said to be complete has all of its messages and samples, by another reader's count."""
    plain = PlainSignals(path)
    plain.assert_whole()
    assert {topic: of.messages for topic, of in whole.topics.items()} == plain.counts
    if plain.spans and not plain.decimated:
        first, *_, end = next((spans[0].first, spans[-1].end) for spans in plain.spans.values())
        assert (whole.first_step, whole.steps) == (first, end - first)
        with bounded():
            strict = read_bag(path)
        assert len(strict) == end - first


def _tried(operation: Callable[[Path], Any], path: Path) -> Any:
    """What an operation returns; None if it rejects the bag in an error of ours."""
    try:
        with bounded():
            return operation(path)
    except WheelsetTrackError as reason:
        refusal = str(reason)
    assert refusal.isprintable()
    return None


def _play(path: Path) -> None:
    with RecordedBag(path) as bag:
        for topic in bag.topics.values():
            assert topic.depth > 0
            assert {topic.latched, topic.reliable, topic.stamped, topic.outdated} <= {True, False}
        selection = Selection(bag, bag.topics)
        for message in selection.played(0, 2**62):
            assert selection.span_ns(message) >= 0
        assert all(message.time_ns >= 0 for message in selection.held_at(selection.end_ns))


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
def changed_messages(draw: st.DrawFn, entries: list[Entry], kept: tuple[str, ...] = ()) -> list[Entry]:
    """Entries, one to four of which have a field of another value that its type can hold, or are moved or missing.

    Scenarios in them keep the keys in ``kept``.
    """
    found = list(entries)
    hows = ["field", "field", "field", "field", "time", "topic", "remove", "double", "bytes", "of topic"]
    for _ in range(draw(st.integers(1, 4))):
        number = draw(st.integers(0, len(found) - 1))
        entry = found[number]
        how = draw(st.sampled_from(hows))
        if how == "field":
            try:
                message = deserialise(short_name(entry.type), entry.data)
            except Exception:  # noqa: BLE001  changed before
                continue
            *path, last = draw(st.sampled_from(_fields(message)))
            place = message
            for name in path:
                place = getattr(place, name)
            object.__setattr__(place, last, _like(draw, getattr(place, last), kept))
            with suppress(Exception):  # the type cannot hold it
                found[number] = entry._replace(data=bytes(typestore().serialize_cdr(message, entry.type)))
        elif how == "time":
            found[number] = entry._replace(
                time_ns=draw(st.sampled_from([0, 1, 2**62, 2**63 + 5, entry.time_ns + 10**15]))
            )
        elif how == "topic":
            found[number] = entry._replace(
                topic=draw(st.sampled_from(["", "x", "/a b", "\x1b[2J", "\x9b2J\u202e", entry.topic + "/x"]))
            )
        elif how == "of topic":
            change = draw(_changed_topic(entry))
            found = [each._replace(**change) if each.topic == entry.topic else each for each in found]
        elif how == "remove" and len(found) > 1:
            del found[number]
        elif how == "double":
            found.insert(number, entry)
        else:
            found[number] = entry._replace(data=draw(mutated_bytes(entry.data)))
    return found


@st.composite
def _changed_topic(draw: st.DrawFn, entry: Entry) -> dict[str, Any]:
    """Another definition, type or quality of service of a topic."""
    how = draw(st.sampled_from(["lines", "bytes", "type", "metadata"]))
    if how == "lines":
        lines = entry.definition.splitlines(keepends=True)
        place = draw(st.integers(0, len(lines) - 1))
        other = draw(st.sampled_from([[], [lines[place]] * 2, [b"float64 x\n"], [b"wheelset_track_msgs/State y\n"]]))
        return {"definition": b"".join([*lines[:place], *other, *lines[place + 1 :]])}
    if how == "bytes":
        return {"definition": draw(mutated_bytes(entry.definition))}
    if how == "type":
        return {"type": draw(st.sampled_from([FORCES, STRESS, "std_msgs/msg/String", "os/msg/System", "x", ""]))}
    with suppress(Exception):  # no YAML
        profiles = parse(entry.metadata.get("offered_qos_profiles", "[]"), "qualities")
        return {"metadata": {**entry.metadata, "offered_qos_profiles": dump(draw(mutated_trees(profiles)))}}
    return {"metadata": {}}


def _like(draw: st.DrawFn, value: Any, kept: tuple[str, ...]) -> Any:
    """A value of the same kind as another one."""
    if isinstance(value, np.ndarray):
        length = draw(st.sampled_from([0, 1, len(value) - 1, len(value) + 1, len(value)]))
        found = np.resize(value, max(length, 0)).copy() if len(value) else np.zeros(max(length, 0), value.dtype)
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
        content = None
        with suppress(InputError):  # changed before
            content = parse(value, "text") if ": " in value else None
        if not isinstance(content, dict):
            return draw(st.sampled_from(["{a: " * 30, "\x1b]0;x\x07\x9b1m\u202ea", "a\nb", "x" * 100_000]))
        return _scenario(draw, content, kept)
    return draw(st.sampled_from([value[:-1], value + value])) if isinstance(value, list) else value


def _scenario(draw: st.DrawFn, content: dict[str, Any], kept: tuple[str, ...]) -> str:
    other = draw(mutated_trees(content))
    if isinstance(other, dict):
        other |= {name: content[name] for name in kept if name in content}
    elif kept:
        other = content
    with suppress(Exception):  # no YAML
        return dump(other)
    return "{a: " * 30


@st.composite
def changed_metadata(draw: st.DrawFn, records: list[Any]) -> list[Metadata]:
    """Records of metadata with other texts."""
    changed = []
    for each in records:
        found = draw(mutated_trees(dict(each.metadata)))
        pairs = found.items() if isinstance(found, dict) else [("", found)]
        texts = {str(key).encode(errors="replace").decode(): _text(value) for key, value in pairs}
        changed.append(Metadata(each.name, texts))
    return changed


def _text(value: Any) -> str:
    text = "9" * 400 if type(value) is int and value > 2**64 else str(value)
    return text[:10_000].encode(errors="replace").decode()


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
    use(write(folder / "records.mcap", entries, data.draw(changed_metadata(records))), folder)


@quiet
@given(data=st.data(), kind=KINDS)
def test_structure(folder: Path, source: tuple[list[Entry], list[Any]], data: st.DataObject, kind: Kind) -> None:
    path = write(folder / "structure.mcap", *source, replace(kind, pace=1))
    path.write_bytes(data.draw(changed_records(path.read_bytes())))
    use(path, folder)


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


@quiet
@given(data=st.data())
def test_resimulation(folder: Path, simulated: tuple[list[Entry], list[Any]], data: st.DataObject) -> None:
    """Only samples that are those of the run are called identical, and all of the bag's are counted."""
    entries, records = simulated
    changed = data.draw(changed_messages(entries, OF_MODELS))
    path = write(folder / "resimulation.mcap", changed, records)
    found = _tried(lambda path: resimulate(path, most_steps=STEPS), path)
    if found is None or not found.identical:
        return
    if not found.lost and not found.left_out:
        spans = PlainSignals(path).spans.values()
        assert {found.samples} == {sum(span.end - span.first for span in signal) for signal in spans}
    run = read_bag(folder / "simulated.mcap")
    held = read_bag(path, lost=lambda _: None)
    if not found.inputs.start:
        np.testing.assert_array_equal(held.forces, run.forces[held.steps.astype(int)])


@quiet
@given(data=st.data(), command=st.sampled_from(COMMANDS))
def test_commands(
    folder: Path, simulated: tuple[list[Entry], list[Any]], data: st.DataObject, command: tuple[str, ...]
) -> None:
    """A status, text that does nothing to a terminal, one line of error, and one JSON object if that is asked for."""
    entries, records = simulated
    changed = data.draw(changed_messages(entries, OF_MODELS))
    others = [
        Metadata(each.name, {name: text for name, text in each.metadata.items() if name != "crc32"}) for each in records
    ]
    path = write(
        folder / "commands.mcap", changed, data.draw(changed_metadata(others)) if data.draw(st.booleans()) else records
    )
    new = folder / "new"
    named = {"BAG": str(path), "SOURCE": str(folder / "simulated.mcap")}
    arguments = [named.get(each, each.replace("NEW", str(new / "x"))) for each in command]
    new.mkdir(exist_ok=True)
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err, bounded():
        status = main(arguments)
    assert status in (0, 1, 2)
    for text in (out.getvalue(), err.getvalue()):
        assert all(line.isprintable() for line in text.split("\n"))
    told = [line for line in err.getvalue().splitlines() if line.startswith(PROGRAM)]
    errors = [line for line in told if not line.startswith(f"{PROGRAM}: warning: ")]
    assert len(errors) <= 1, errors
    assert bool(errors) == (status == 2) or status == 1, (status, errors)
    if "--json" in command and not errors:
        json.loads(out.getvalue())
    for file in new.iterdir():
        file.unlink()
