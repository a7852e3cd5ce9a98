"""Bags of rosbag2 that are no MCAP files: SQLite, and files that were compressed as a whole."""

import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer

from support.rewriting import Entry, entries_of
from wheelset_track_sim.bags import Recording, read_bag
from wheelset_track_sim.bags.mcap.unpacking import LARGEST
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.bags.stored_files import SQLITE, UNPACKED_PER_BYTE
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import NoBagError, RecordingError

CHUNKS, LENGTH = 6, 20
LIST = "rosbag2_bagfile_information:\n  relative_file_paths:\n"


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory, make_small_run: Callable[..., object]) -> Path:
    path = tmp_path_factory.mktemp("source") / "run.mcap"
    make_small_run(path, chunks=CHUNKS, length=LENGTH)
    return path


@pytest.fixture(scope="module")
def whole(source: Path) -> Recording:
    return read_bag(source)


def as_sqlite(source: Path, folder: Path) -> Path:
    """The same messages in an SQLite bag of another writer; the path of its file."""
    seconds = QosTime(9223372036, 854775807)
    latched = Qos(
        QosHistory.KEEP_LAST,
        1,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL,
        seconds,
        seconds,
        QosLiveliness.AUTOMATIC,
        seconds,
        avoid_ros_namespace_conventions=False,
    )
    entries, _ = entries_of(source)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {}
        for entry in entries:
            if entry.topic not in connections:
                connections[entry.topic] = writer.add_connection(
                    entry.topic,
                    entry.type,
                    msgdef=entry.definition.decode(),
                    rihs01="RIHS01_" + 64 * "0",
                    offered_qos_profiles=[latched] if entry.topic.endswith("/state") else [],
                )
            writer.write(connections[entry.topic], entry.time_ns, entry.data)
    [file] = folder.glob("*.db3")
    return file


@pytest.fixture(scope="module")
def sqlite_bag(tmp_path_factory: pytest.TempPathFactory, source: Path) -> Path:
    return as_sqlite(source, tmp_path_factory.mktemp("sqlite") / "run").parent


def pack(file: Path, to: Path) -> Path:
    """A file as ``ros2 bag record --compression-mode file`` leaves it."""
    packed = to / f"{file.name}.zstd"
    packed.write_bytes(zstandard.compress(file.read_bytes()))
    return packed


def assert_whole(bag: Path, whole: Recording, source: Path, saved: Path) -> None:
    """A bag is read, listed, played and recovered as its source."""
    entries: list[Entry] = entries_of(source)[0]
    found = read_bag(bag)
    assert found.forces.tobytes() == whole.forces.tobytes()
    nodes = [found.nodes.index(node) for node in whole.nodes]
    assert found.stresses[:, nodes].tobytes() == whole.stresses.tobytes()
    assert found.states == whole.states
    part = read_bag(bag, steps=(30, 50))
    np.testing.assert_array_equal(part.steps, np.arange(30, 50))
    seen = overview(bag)
    assert seen.steps == CHUNKS * LENGTH
    assert {topic: count.messages for topic, count in seen.topics.items()} == {
        topic: sum(entry.topic == topic for entry in entries) for topic in {entry.topic for entry in entries}
    }
    with RecordedBag(bag) as opened:
        played = [message[:3] for message in opened.messages(0, 2**62, {*opened.topics})]
        assert opened.damages == []
        assert [name for name, topic in opened.topics.items() if topic.latched] == ["/wheelset_track_sim/state"]
        assert opened.topics["/wheelset_track_sim/state"].depth == 1
    assert sorted(played) == sorted((entry.time_ns, entry.topic, entry.data) for entry in entries)
    recovered = recover(bag, saved)
    assert (recovered.steps, recovered.messages, recovered.losses) == (CHUNKS * LENGTH, len(entries), ())
    assert {entry.data for entry in entries_of(saved)[0]} == {entry.data for entry in entries}


def test_an_sqlite_bag(sqlite_bag: Path, whole: Recording, source: Path, tmp_path: Path) -> None:
    assert_whole(sqlite_bag, whole, source, tmp_path / "folder.mcap")
    assert_whole(sqlite_bag / "run.db3", whole, source, tmp_path / "file.mcap")
    assert overview(sqlite_bag).complete


def test_a_bag_without_the_tables_of_later_versions(
    sqlite_bag: Path, whole: Recording, source: Path, tmp_path: Path
) -> None:
    """Humble stores neither definitions nor hashes."""
    file = Path(shutil.copy(sqlite_bag / "run.db3", tmp_path / "old.db3"))
    with sqlite3.connect(file) as database:
        database.execute("DROP TABLE message_definitions")
        database.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
    database.close()
    assert_whole(file, whole, source, tmp_path / "saved.mcap")


@pytest.mark.parametrize("storage", ["mcap", "db3"])
@pytest.mark.parametrize("opened_before", [False, True])
@pytest.mark.parametrize("listed", [False, True])
def test_files_that_were_compressed_as_a_whole(
    source: Path,
    sqlite_bag: Path,
    whole: Recording,
    tmp_path: Path,
    storage: str,
    opened_before: bool,
    listed: bool,
) -> None:
    """``ros2 bag`` unpacks such files beside the packed ones when it opens a folder, and leaves them there."""
    file = source if storage == "mcap" else sqlite_bag / "run.db3"
    bag = tmp_path / "bag"
    bag.mkdir()
    packed = pack(file, bag)
    if opened_before:
        shutil.copy(file, bag)
    if listed:
        (bag / "metadata.yaml").write_text(f"{LIST}  - {packed.name}\n")
    if listed:
        assert_whole(bag, whole, source, tmp_path / "saved.mcap")
    found = overview(bag)
    assert [*found.files] == [packed.name]
    assert found.complete == listed
    assert not any("left out" in line for line in found.unchecked)
    packed.unlink()
    if opened_before:  # the answer is the same if the packed file has been removed since
        assert read_bag(bag).forces.tobytes() == whole.forces.tobytes()


def test_a_packed_file_alone_has_its_page_beside_it(source: Path, tmp_path: Path) -> None:
    packed = pack(source, tmp_path)
    assert recover(packed).path == tmp_path / "run_recovered"


def test_a_packed_file_that_is_cut_off(source: Path, tmp_path: Path) -> None:
    content = zstandard.ZstdCompressor(level=1).compress(source.read_bytes() + bytes(1 << 20))
    (tmp_path / "run.mcap.zstd").write_bytes(content[: len(content) // 2])
    with pytest.raises(RecordingError, match="is not a complete bag"):
        read_bag(tmp_path / "run.mcap.zstd")
    assert not complete(tmp_path / "run.mcap.zstd")


def complete(path: Path) -> bool:
    try:
        return overview(path).complete
    except RecordingError:
        return False


def test_a_packed_file_that_unpacks_to_too_much(tmp_path: Path, source: Path) -> None:
    head, zeros = source.read_bytes(), bytes(1 << 24)
    packer = zstandard.ZstdCompressor(level=1).compressobj()
    with (tmp_path / "run.mcap.zstd").open("wb") as file:
        file.write(packer.compress(head))
        for _ in range(LARGEST // len(zeros) + 20):
            file.write(packer.compress(zeros))
        file.write(packer.flush())
    assert (tmp_path / "run.mcap.zstd").stat().st_size * UNPACKED_PER_BYTE < 19 * len(zeros)
    with pytest.raises(RecordingError, match="unpacks to more bytes than a file of its size can"):
        read_bag(tmp_path / "run.mcap.zstd")


def test_a_journal_that_was_not_merged_is_named(sqlite_bag: Path, tmp_path: Path) -> None:
    """As a recorder that was killed leaves it."""
    file = Path(shutil.copy(sqlite_bag / "run.db3", tmp_path))
    (tmp_path / "run.db3-wal").write_bytes(b"messages")
    with pytest.raises(RecordingError, match=r"messages are in run\.db3-wal only"):
        read_bag(file)
    assert not overview(file).complete


@pytest.mark.parametrize("at", [0.3, 0.6, 0.9])
def test_a_damaged_database_is_not_complete(sqlite_bag: Path, tmp_path: Path, at: float) -> None:
    file = Path(shutil.copy(sqlite_bag / "run.db3", tmp_path))
    content = bytearray(file.read_bytes())
    place = int(at * len(content)) // 4096 * 4096
    file.write_bytes(content[:place])
    with pytest.raises(RecordingError):
        read_bag(file)
    assert not complete(file)


@pytest.mark.parametrize(
    "script",
    [
        "CREATE TABLE notes(text)",
        "CREATE VIEW messages AS SELECT 1 AS id, 1 AS topic_id, 1 AS timestamp, zeroblob(900000000) AS data;"
        "CREATE TABLE topics(id, name, type, serialization_format)",
        "CREATE TABLE messages(id, topic_id, timestamp, data AS (zeroblob(900000000)));"
        "CREATE TABLE topics(id, name, type, serialization_format)",
    ],
)
def test_a_database_that_is_no_bag(tmp_path: Path, script: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither views nor computed columns are read: they may make gigabytes of a few bytes."""
    file = tmp_path / "notes.db3"
    with sqlite3.connect(file) as database:
        database.executescript(script)
        if "VIEW" not in script and "messages" in script:
            database.execute("INSERT INTO messages VALUES (1, 1, 1)")
    database.close()
    with pytest.raises(NoBagError, match="SQLite file, but no bag of ros2 bag"):
        read_bag(file)
    assert main(["info", str(file)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_rows_that_are_no_messages_are_reported(sqlite_bag: Path, tmp_path: Path) -> None:
    file = Path(shutil.copy(sqlite_bag / "run.db3", tmp_path))
    with sqlite3.connect(file) as database:
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (999, 5, x'00')")
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, 'then', x'00')")
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, 5, 'text')")
    database.close()
    [loss] = overview(file).losses
    assert str(loss) == "run.db3: 3 messages have no topic, no time or no bytes"


def test_the_beginning_of_a_database_alone(tmp_path: Path) -> None:
    (tmp_path / "run.db3").write_bytes(SQLITE)
    with pytest.raises(RecordingError, match=r"run\.db3"):
        read_bag(tmp_path / "run.db3")
