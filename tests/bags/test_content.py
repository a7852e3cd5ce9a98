"""Bags whose checksums are right and whose content is not: a located loss or one line, and nothing else."""

import base64
import json
import math
import os
import re
import zlib
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.records import Metadata

from support.rewriting import Entry, Kind, changed, entries_of, write
from wheelset_track_sim.bags import Bag, read_bag
from wheelset_track_sim.bags.definitions import schema
from wheelset_track_sim.bags.messages import impact_message
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.playback.selection import Selection
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.bags.run_info import RunInfo, _checksum, decode_inputs
from wheelset_track_sim.errors import RecordingError, WheelsetTrackError
from wheelset_track_sim.inputs.yaml12 import dump
from wheelset_track_sim.report.survey import survey
from wheelset_track_sim.samples.impacts import Impact
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.twin.run_inputs import run_inputs

CHUNKS, LENGTH = 6, 20
STEPS = CHUNKS * LENGTH
FORCES, STRESS, SUMMARY, STATE = (
    f"wheelset_track_msgs/msg/{kind}" for kind in ("ContactForces", "AxleStress", "LoadSummary", "SimulationState")
)


class Source:
    """A run: its messages, and what is said of it."""

    def __init__(self, path: Path) -> None:
        self.entries, self.records = entries_of(path)

    def __repr__(self) -> str:
        return "Source"

    def of(self, kind: str) -> list[int]:
        """Numbers of the messages of a type."""
        return [number for number, entry in enumerate(self.entries) if entry.type == kind]

    def with_content(self, number: int, change: Callable[[Any], object]) -> list[Entry]:
        """Messages, one of which has another content."""
        return [changed(entry, change) if n == number else entry for n, entry in enumerate(self.entries)]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory, make_small_run: Callable[..., object]) -> Source:
    path = tmp_path_factory.mktemp("source") / "run.mcap"
    make_small_run(path, chunks=CHUNKS, length=LENGTH)
    return Source(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("content")


def played(path: Path) -> None:
    with RecordedBag(path) as bag:
        selection = Selection(bag, bag.topics)
        for message in selection.played(0, 2**63):
            selection.span_ns(message)


def inputs(path: Path) -> None:
    run_inputs(Bag(path, [].append))


def assert_held(path: Path) -> None:
    """No command raises anything but an error in one line."""
    for use in (
        lambda: read_bag(path),
        lambda: read_bag(path, lost=[].append),
        lambda: read_bag(path, steps=(30, 50), lost=[].append),
        lambda: overview(path),
        lambda: survey(path),
        lambda: recover(path, path.with_name("saved.mcap")),
        lambda: played(path),
        lambda: inputs(path),
    ):
        told = ""
        try:
            use()
        except WheelsetTrackError as refusal:
            told = str(refusal)
        assert "\n" not in told
        assert len(told) < 2100
    path.with_name("saved.mcap").unlink(missing_ok=True)


def array(name: str, index: int, value: float) -> Callable[[Any], None]:
    def change(message: Any) -> None:
        values = np.array(getattr(message, name))
        values[index] = value
        setattr(message, name, values)

    return change


def field(name: str, value: Any) -> Callable[[Any], None]:
    return lambda message: setattr(message, name, value)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("kind", "name", "index", "named"),
    [
        (FORCES, "wheel_2", 7, "contact force wheel_2 at step 47 is"),
        (STRESS, "xz", 3, r"stress [ABC]1 xz at step \d+ is"),
        (FORCES, "time", None, "time at step 40 is"),
        (FORCES, "speed", None, "speed at step 40 is"),
        (FORCES, "position", None, "position at step 40 is"),
        (STATE, "speed", None, r"speed at step \d+ is"),
        (STATE, "axle_load", None, r"axle_load at step \d+ is"),
    ],
)
def test_numbers_that_are_none_are_refused_and_named(
    tmp_path: Path, source: Source, kind: str, name: str, index: int | None, named: str, value: float
) -> None:
    number = source.of(kind)[2 if kind == FORCES else -1]
    change = field(name, value) if index is None else array(name, index, value)
    path = write(tmp_path / "run.mcap", source.with_content(number, change), source.records)
    with pytest.raises(RecordingError, match=rf"{named} {value}"):
        read_bag(path)
    losses: list[object] = []
    found = read_bag(path, lost=losses.append)
    assert any(str(value) in str(loss) for loss in losses)
    assert len(found) == (STEPS if kind == STATE else STEPS - LENGTH)
    assert np.isfinite(found.forces).all()
    assert_held(path)


@pytest.mark.parametrize(
    ("kind", "change", "reason"),
    [
        (STRESS, field("yz", np.zeros(0)), "its arrays differ in length, 20 xx, .* 0 yz"),
        (FORCES, field("wheel_1", np.zeros(7)), "its arrays differ in length, 7 wheel_1, 20 wheel_2"),
        (FORCES, field("step_period", 0.0), r"step period 0 s at step \d+ are not those of a run"),
        (FORCES, field("speed", -3.0), "speed -3 m/s .* are not those of a run"),
        (FORCES, field("time", 1e300), r"step \d+ at 1e\+300 s is after"),
        (SUMMARY, field("max_principal_rms", np.zeros(5)), "it names 3 nodes, and has the extremes of others"),
        (SUMMARY, field("wheel_1_max_force", math.nan), "max_force of wheel 1 from step .* is nan"),
        (SUMMARY, field("samples", 0), "it holds no samples"),
        (SUMMARY, field("wheel_1_rms_force", 1e200), r"rms_force of wheel 1 from step .* is 1e\+200"),
        (SUMMARY, array("max_principal_max", 1, -1e200), "extremes of stresses from step .* are beyond 1e\\+30 Pa"),
        (FORCES, array("wheel_1", 1, 1e200), r"wheel_1 from step \d+ on has 1e\+200"),
    ],
)
def test_what_no_run_can_have_is_a_located_loss(
    tmp_path: Path, source: Source, kind: str, change: Callable[[Any], object], reason: str
) -> None:
    path = write(tmp_path / "run.mcap", source.with_content(source.of(kind)[3], change), source.records)
    found = overview(path)
    assert not found.complete
    [loss] = [loss for loss in found.losses if "bytes" in str(loss)]
    assert re.search(reason, str(loss)), loss
    assert_held(path)


@given(
    st.sampled_from((FORCES, STRESS, SUMMARY, STATE)),
    st.integers(0, 100),
    st.integers(0, 10_000),
    st.sampled_from([b"\xff", b"\0", b"\x7f\xf0", b"\xff" * 8, bytes(8)]),
    st.sampled_from([Kind(), Kind(chunked=False, statistics=False)]),
)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_in_any_message(
    folder: Path, source: Source, what: str, number: int, place: int, new: bytes, kind: Kind
) -> None:
    entries = [*source.entries]
    numbers = source.of(what)
    chosen = numbers[number % len(numbers)]
    data = bytearray(entries[chosen].data)
    place %= len(data)
    data[place : place + len(new)] = new
    entries[chosen] = entries[chosen]._replace(data=bytes(data))
    assert_held(write(folder / "run.mcap", entries, source.records, kind))


@given(st.integers(0, 100), st.integers(0, 3), st.integers(0, 60))
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_messages_that_are_cut_off(folder: Path, source: Source, number: int, kind: int, length: int) -> None:
    numbers = source.of((FORCES, STRESS, SUMMARY, STATE)[kind])
    entries = [*source.entries]
    chosen = numbers[number % len(numbers)]
    entries[chosen] = entries[chosen]._replace(data=entries[chosen].data[:length])
    assert_held(write(folder / "run.mcap", entries, source.records))


@given(st.integers(0, 100), st.integers(2**62, 2**64 - 1))
@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_times_that_no_clock_has(folder: Path, source: Source, number: int, time: int) -> None:
    entries = [*source.entries]
    chosen = number % len(entries)
    entries[chosen] = entries[chosen]._replace(time_ns=time)
    assert_held(write(folder / "run.mcap", entries, source.records))


def record_with(records: list[Metadata], **changes: str) -> list[Metadata]:
    """The record of a run with other texts, and the checksum that fits them."""
    [record] = records
    found = {**record.metadata, **changes}
    return [Metadata(record.name, {**found, "crc32": _checksum(found)})]


def packed(text: str) -> str:
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()


SCENARIOS = ("&a [*a]", "5", "name: &n x\nspeed: *n", "a: " + "[" * 3000, "speed: 1" + "0" * 400, "", "\0", "- 1\n- 2")


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_scenarios_that_are_none(tmp_path: Path, source: Source, scenario: str) -> None:
    text = packed(json.dumps([[0, 0, scenario], [1, 40, f"speed: 3\n{scenario}"]]))
    records = record_with(source.records, scenario=scenario, inputs=text)
    assert_held(write(tmp_path / "run.mcap", source.entries, records))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('[[0, 1e400, "a"]]', "not of two whole numbers and a text"),
        ('[[0, 0, "a"], [true, 1, "a"]]', "not of two whole numbers and a text"),
        ("[[0, 1" + "0" * 400 + ', "a"]]', "a revision or a step that cannot be"),
        ("[" * 100_000, "inputs of the run cannot be read"),
        ("[[0, 0]]", "inputs of the run cannot be read"),
        ('{"a": 1}', "inputs of the run cannot be read"),
        ("[" + "[], " * 100_000 + "[]]", "not of two whole numbers and a text"),
        ("[" + '[1, 1, "a"], ' * 10_000 + '[1, 1, "a"]]', "there are more than 10000"),
    ],
    ids=["infinite", "truth", "digits", "deep", "short", "mapping", "lists", "many"],
)
def test_inputs_that_are_none(tmp_path: Path, source: Source, text: str, reason: str) -> None:
    records = record_with(source.records, inputs=packed(text))
    with pytest.raises(ValueError, match=reason):
        RunInfo.among(records[0].name, records[0].metadata)
    path = write(tmp_path / "run.mcap", source.entries, records)
    losses: list[object] = []
    assert len(read_bag(path, lost=losses.append)) == STEPS
    found = overview(path)
    assert not found.complete
    assert any("the description of its run cannot be read" in str(loss) for loss in found.losses)
    assert_held(path)


@pytest.mark.parametrize("what", [FORCES, STRESS])
def test_samples_that_come_twice_are_a_loss(tmp_path: Path, source: Source, what: str) -> None:
    """It cannot be told which of the two is right."""
    number = source.of(what)[4]
    twice = [*source.entries[:number], source.entries[number], *source.entries[number:]]
    path = write(tmp_path / "run.mcap", twice, source.records)
    found = overview(path)
    assert not found.complete
    assert any("come twice" in str(loss) or "incomplete without" in str(loss) for loss in found.losses)
    with pytest.raises(RecordingError, match=r"come twice|incomplete without"):
        read_bag(path)
    assert len(read_bag(path, lost=[].append)) == STEPS


@pytest.mark.parametrize("key", ["track", "wheelset", "vehicle", "roughness", "profile", "profiles"])
@pytest.mark.parametrize("name", ["secret", "./secret.csv", "secret.npz"])
def test_a_scenario_of_a_bag_opens_no_file(
    tmp_path: Path, source: Source, key: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever names one, and however it is written."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo(name)
    content: Any = {"base": name} if key in ("track", "wheelset", "vehicle") else {"wheel_1": {"file": name}}
    if key in ("roughness", "profile"):
        key, content = "irregularities", [{"type": key, "on": "wheel_1", "file": name}]
    scenario = dump(load_scenario("undamaged").to_mapping() | {key: content})
    records = record_with(source.records, scenario=scenario, inputs=packed(json.dumps([[0, 0, scenario]])))
    path = write(tmp_path / "run.mcap", source.entries, records)
    with pytest.raises(RecordingError, match="scenario of revision 0 cannot be used here") as refusal:
        run_inputs(Bag(path))
    assert "pipe" not in str(refusal.value)  # nobody has looked
    assert survey(path).scenario is None


@pytest.mark.slow
def test_inputs_unpack_to_a_bounded_size() -> None:
    packer = zlib.compressobj(1)
    data = b"".join([*(packer.compress(bytes(1 << 23)) for _ in range(64)), packer.flush()])
    with pytest.raises(ValueError, match="they have more than 268435456 bytes"):
        decode_inputs(base64.b64encode(data).decode())


@pytest.mark.parametrize(
    "definition",
    [
        b"",
        b"float64 x",
        b"\xff\xfe",
        b"wheelset_track_msgs/ContactForces again",
        b"=" * 9,
        b"\n" * 100_000,
        b" " * 100_000 + b"x",
        b"float64 x\n" * 20_000,
        schema("AxleStress").encode() + b"\n" * 120_000,
    ],
    ids=range(9),
)
def test_definitions_that_are_none(tmp_path: Path, source: Source, definition: bytes) -> None:
    entries = [entry._replace(definition=definition) if entry.type == STRESS else entry for entry in source.entries]
    assert_held(write(tmp_path / "run.mcap", entries, source.records))


@pytest.mark.parametrize("depth", ["99999999999999999999", "-1", "true", "{a: 1}", "1" + "0" * 400])
def test_qualities_of_service_that_are_none(tmp_path: Path, source: Source, depth: str) -> None:
    profiles = f"- {{history: keep_last, depth: {depth}}}"
    path = write(
        tmp_path / "run.mcap", [entry._replace(metadata={"offered_qos_profiles": profiles}) for entry in source.entries]
    )
    with RecordedBag(path) as bag:
        assert all(1 <= topic.depth <= 10_000 for topic in bag.topics.values())


def test_an_impact_of_a_wheel_that_is_not_there(tmp_path: Path, source: Source) -> None:
    numbers = dict.fromkeys((each.name for each in fields(Impact)), 1)
    impact = impact_message(Impact(**numbers), 0)
    entry = Entry(
        "/wheelset_track_sim/impacts",
        "wheelset_track_msgs/msg/WheelImpact",
        schema("WheelImpact").encode(),
        {},
        source.entries[-1].time_ns,
        impact.cdr,
    )
    path = write(tmp_path / "run.mcap", [*source.entries, changed(entry, field("wheel", 7))], source.records)
    found = overview(path)
    assert found.impacts == (0, 0)
    assert any("wheel 7 is neither 1 nor 2" in str(loss) for loss in found.losses)
    assert_held(path)
