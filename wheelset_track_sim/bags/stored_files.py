"""Open the files of a bag, in whatever storage ``ros2 bag`` has put them, as MCAP.

A file that was compressed as a whole (``--compression-mode file``) is unpacked, and an SQLite file is copied into MCAP,
both into temporary files. Their content decides and not their names.
"""

from __future__ import annotations

import sqlite3
import tempfile
import weakref
from array import array
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from zstandard import ZstdDecompressor, ZstdError

from ..errors import NoBagError, RecordingError
from .mcap.reader import CHUNK_START
from .mcap.unpacking import LARGEST, LARGEST_WINDOW, ZSTD
from .mcap.writer import MAGIC, McapWriter
from .topics import PROFILES, TYPE_HASH

SQLITE = b"SQLite format 3\0"
UNPACKED_PER_BYTE = 100
"""Bytes that a compressed file is unpacked to: ``LARGEST``, and so many for each of its own."""
STEPS, STEPS_PER_BYTE = 10_000_000, 100
"""Instructions of SQLite that a file is read with: so many, and more by its size."""
ROWS, ROWS_PER_BYTE = 1000, 0.1
"""Messages that are listed: so many, and more by the size of the file."""
COPIED = 1 << 20
"""Bytes that are unpacked at a time, and that make a chunk."""
ASKED = 100_000
"""Instructions after which SQLite asks whether to go on."""
WANTED = {
    "topics": {"id", "name", "type", "serialization_format"},
    "messages": {"id", "topic_id", "timestamp", "data"},
}
"""Columns of the tables of a bag."""


class _Copy:
    """A temporary file without a name, which goes with the last reader of it."""

    def __init__(self) -> None:
        self.stream: Any = tempfile.TemporaryFile("w+b")  # noqa: SIM115  see the next line
        weakref.finalize(self, self.stream.close)
        self.damage = ""
        """Why it does not hold everything; empty if it does."""

    @property
    def path(self) -> Path:
        """A path under which this process can open it."""
        return Path(f"/proc/self/fd/{self.stream.fileno()}")


class StoredFiles:
    """The files of a bag as MCAP; copies are made once, and go with this object."""

    def __init__(self) -> None:
        self._copies: dict[Path, _Copy | None] = {}

    @contextmanager
    def opened(self, file: Path, damaged: Callable[[str], object]) -> Iterator[BinaryIO]:
        """A file as MCAP; ``damaged`` is called with the reason if it cannot be copied to its end.

        Raises OSError if it cannot be read, RecordingError if there is no room for the copy, NoBagError for an SQLite
        file that is no bag.
        """
        if file not in self._copies:
            self._copies[file] = _copy_of(file)
        copy = self._copies[file]
        if copy is not None and copy.damage:
            damaged(copy.damage)
        with (copy.path if copy else file).open("rb") as stream:
            yield stream


def is_bag(stream: BinaryIO) -> bool:
    """Whether a stream is an MCAP file, or what is left of one: it begins or ends as such, or has a chunk somewhere."""
    size = stream.seek(0, 2)
    if size == 0:
        return True  # a recorder that was killed at once leaves it
    found = []
    for place in (0, max(0, size - len(MAGIC))):
        stream.seek(place)
        found.append(stream.read(len(MAGIC)))
    if MAGIC in found:
        return True
    stream.seek(0)
    before = b""
    while data := stream.read(COPIED):
        if CHUNK_START.search(before + data):
            return True
        before = data[-64:]
    return False


def _copy_of(file: Path) -> _Copy | None:
    """A copy of a file as MCAP; None if it is such a file, or no file of rosbag2."""
    with file.open("rb") as stream:
        packed = stream.read(len(ZSTD)) == ZSTD
        stream.seek(0)
        source = _filled(file, lambda copy: _unpack(stream, copy)) if packed else None
    with (source.path if source else file).open("rb") as stream:
        if stream.read(len(SQLITE)) != SQLITE:
            return source
    if source is not None:  # SQLite needs a name
        with tempfile.NamedTemporaryFile(prefix="wheelset_track_sim_") as named:
            source.stream.seek(0)
            while data := source.stream.read(COPIED):
                named.write(data)
            named.flush()
            copy = _filled(file, lambda copy: _from_sqlite(Path(named.name), copy))
        copy.damage = copy.damage or source.damage
        return copy
    return _filled(file, lambda copy: _from_sqlite(file, copy))


def _filled(file: Path, fill: Callable[[BinaryIO], str]) -> _Copy:
    try:
        copy = _Copy()
        copy.damage = fill(copy.stream)
        copy.stream.flush()
    except OSError as reason:
        raise RecordingError(
            f"{file} cannot be unpacked to {tempfile.gettempdir()} ({reason.strerror}): free space, or set TMPDIR"
        ) from None
    except _NotOfRosbag2:
        raise NoBagError(
            f"{file} is an SQLite file, but no bag of ros2 bag: give a bag folder or an .mcap file"
        ) from None
    return copy


def _unpack(stream: BinaryIO, copy: BinaryIO) -> str:
    """Unpack a zstd file as far as possible; returns why it ends before its end."""
    left = LARGEST + UNPACKED_PER_BYTE * stream.seek(0, 2)
    stream.seek(0)
    try:
        with ZstdDecompressor(max_window_size=LARGEST_WINDOW).stream_reader(
            stream, read_across_frames=True, closefd=False
        ) as unpacked:
            while data := unpacked.read(COPIED):
                left -= len(data)
                if left < 0:
                    return "it unpacks to more bytes than a file of its size can"
                copy.write(data)
    except ZstdError as reason:
        return f"it cannot be unpacked to its end ({' '.join(str(reason).split())})"
    return ""


class _NotOfRosbag2(Exception):  # noqa: N818
    """A database has other tables."""


def _from_sqlite(file: Path, copy: BinaryIO) -> str:
    """Copy the messages of an SQLite file into MCAP, in the order of time; returns why some are missing.

    The file may come from anywhere: views, virtual tables and computed columns are not read, and the work is bounded by
    its size.
    """
    size = file.stat().st_size
    mcap = McapWriter(copy, "ros2", "wheelset_track_sim")
    left = [STEPS + STEPS_PER_BYTE * size]

    def over() -> bool:
        left[0] -= ASKED
        return left[0] < 0

    journal = file.with_name(f"{file.name}-wal")
    damage = ""
    with closing(sqlite3.connect(f"{file.absolute().as_uri()}?mode=ro&immutable=1", uri=True)) as database:
        database.set_progress_handler(over, ASKED)
        try:
            database.execute("PRAGMA trusted_schema = OFF")
            _require_tables(database)
            damage = _copy_messages(database, mcap, size)
        except sqlite3.Error as reason:
            damage = f"SQLite cannot read it to its end ({reason})"
        except (UnicodeError, OverflowError, ValueError, TypeError) as reason:
            damage = f"its tables hold what no bag does ({reason})"
    mcap.finish()
    if not damage and journal.exists() and journal.stat().st_size:
        damage = (
            f"it was not closed, and messages are in {journal.name} only: sqlite3 {file.name} 'PRAGMA wal_checkpoint'"
        )
    return damage


def _require_tables(database: sqlite3.Connection) -> None:
    """Raise _NotOfRosbag2 unless the tables of a bag are there, as plain tables with plain columns."""
    plain = {
        str(name)
        for name, text in database.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'")
        if str(text).upper().startswith("CREATE TABLE")
    }
    for table, columns in WANTED.items():
        if table not in plain or not columns <= _columns(database, table):
            raise _NotOfRosbag2


def _columns(database: sqlite3.Connection, table: str) -> set[str]:
    """Columns that are stored: SQLite lists no computed ones here."""
    return {str(row[1]) for row in database.execute(f"PRAGMA table_info({table})")}


def _copy_messages(database: sqlite3.Connection, mcap: McapWriter, size: int) -> str:
    channels = _channels(database, mcap)
    rows, times = array("q"), array("q")
    lost = 0
    for row, time in database.execute("SELECT rowid, timestamp FROM messages"):
        if not isinstance(time, int) or time < 0:
            lost += 1
            continue
        rows.append(row)
        times.append(time)
        if len(rows) > ROWS + ROWS_PER_BYTE * size:
            return "it lists more messages than a file of its size can hold"
    waiting, left = 0, 2 * size
    for number in np.argsort(times, kind="stable").tolist():
        found = database.execute("SELECT topic_id, data FROM messages WHERE rowid = ?", (rows[number],)).fetchone()
        topic, data = found or (None, b"")
        if topic not in channels or not isinstance(data, bytes):
            lost += 1
            continue
        left -= len(data)
        if left < 0:
            return "its messages are longer than the file"
        mcap.add_message(channels[topic], times[number], 0, data)
        waiting += len(data)
        if waiting >= COPIED:
            mcap.flush()
            waiting = 0
    return f"{lost} messages have no topic, no time or no bytes" if lost else ""


def _channels(database: sqlite3.Connection, mcap: McapWriter) -> dict[int, int]:
    """Register all topics; their numbers there by those here. Columns that older versions lack are empty."""
    definitions: dict[str, tuple[str, bytes]] = {}
    if {"topic_type", "encoding", "encoded_message_definition"} <= _columns(database, "message_definitions"):
        for kind, encoding, text in database.execute(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        ):
            definitions.setdefault(str(kind), (str(encoding), str(text).encode()))
    optional = [
        name if name in _columns(database, "topics") else "''"
        for name in ("offered_qos_profiles", "type_description_hash")
    ]
    schemas: dict[str, int] = {}
    channels: dict[int, int] = {}
    for number, name, kind, encoding, profiles, type_hash in database.execute(
        f"SELECT id, name, type, serialization_format, {', '.join(optional)} FROM topics"
    ):
        kind = str(kind)
        if kind not in schemas:
            schemas[kind] = mcap.add_schema(kind, *definitions.get(kind, ("ros2msg", b"")))
        metadata = {PROFILES: str(profiles), TYPE_HASH: str(type_hash)}
        channels[number] = mcap.add_channel(str(name), str(encoding), schemas[kind], metadata)
    return channels
