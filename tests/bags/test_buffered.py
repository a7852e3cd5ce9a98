"""A writer in a thread of its own, before disks that are slow, stand still, are full or are gone."""

import os
import shutil
import threading

import numpy as np
import pytest

from wheelset_track_sim.bags import BagWriter, read_bag
from wheelset_track_sim.bags.buffered import RESERVE, BufferedWriter
from wheelset_track_sim.bags.messages import chunk_messages, state_message
from wheelset_track_sim.errors import InputError, RecordingError

SAMPLES = 1389
"""Of a block: 50 ms, 250 kB."""
PATIENCE = 60.0


class SlowDisk:
    """A pipe in the place of the file that a bag writes: it takes 64 kB, and what ``take`` lets it."""

    def __init__(self, bag):
        self.path = bag.file.with_name("taken.mcap")
        self._taken = bag.file.read_bytes()
        self._out, into = os.pipe()
        os.dup2(into, bag._file._stream.fileno())
        os.close(into)
        self._allowed = threading.Event()
        self._thread = threading.Thread(target=self._take)
        self._thread.start()

    def _take(self):
        self._allowed.wait(PATIENCE)
        while data := os.read(self._out, 1 << 20):
            self._taken += data
        os.close(self._out)

    def take(self):
        self._allowed.set()

    def file(self):
        """The file with all that was taken, when the bag has closed it."""
        self._thread.join(PATIENCE)
        self.path.write_bytes(self._taken)
        return self.path


@pytest.fixture
def told():
    return []


@pytest.fixture
def begin(tmp_path, run_info, told):
    def begin(size=10**8, name="run"):
        bag = BagWriter(tmp_path / name, run_info, start_ns=0)
        return bag, BufferedWriter(bag, size, lambda reason, ended: told.append((str(reason), ended)))

    return begin


@pytest.fixture
def chunk(make_block):
    def chunk(number, revision=0):
        block = make_block(SAMPLES * number, SAMPLES, time=number * 0.05, revision=revision)
        return chunk_messages(block, 0)

    return chunk


@pytest.fixture
def state(make_block, make_state):
    def state(number, revision=0):
        block = make_block(SAMPLES * number, SAMPLES, time=number * 0.05, revision=revision)
        return [state_message(make_state(block), 0)]

    return state


def test_all_is_written_in_its_order(begin, chunk, state, told, tmp_path):
    _, buffered = begin()
    buffered.put(state(0))
    for number in range(10):
        buffered.put(chunk(number))
    assert buffered.split().result(PATIENCE) == tmp_path / "run" / "run_1.mcap"
    with pytest.raises(InputError, match="holds nothing yet"):
        buffered.split().result(PATIENCE)
    with pytest.raises(InputError, match=r"set record\.mode to snapshot"):
        buffered.snapshot().result(PATIENCE)
    buffered.put(chunk(10))
    buffered.close().result(PATIENCE)
    buffered.put(chunk(11))  # too late
    with pytest.raises(InputError, match="is no longer being recorded"):
        buffered.split().result(PATIENCE)
    np.testing.assert_array_equal(read_bag(tmp_path / "run").steps, np.arange(11 * SAMPLES))
    assert told == []
    assert buffered.waiting == 0


def test_a_disk_that_stands_for_a_while_costs_nothing(begin, chunk, told, tmp_path):
    """The pipe takes 64 kB; all else waits in memory while the giver goes on."""
    bag, buffered = begin()
    disk = SlowDisk(bag)
    for number in range(40):
        buffered.put(chunk(number))
    assert buffered.waiting > 8_000_000
    disk.take()
    buffered.close().result(PATIENCE)
    assert told == []
    np.testing.assert_array_equal(read_bag(disk.file()).steps, np.arange(40 * SAMPLES))


def test_beyond_the_bound_samples_are_lost_and_told_by_step(begin, chunk, state, told, tmp_path):
    """The second file of the bag is a file again: it begins behind the gap and says so."""
    bag, buffered = begin(4_000_000)
    disk = SlowDisk(bag)
    buffered.put(state(0))
    highest = 0
    for number in range(40):
        if number == 30:
            buffered.put(state(number, revision=1))  # a change in the gap is kept
        buffered.put(chunk(number, revision=int(number >= 30)))
        highest = max(highest, buffered.waiting)
    assert highest <= 4_000_000 + RESERVE
    [(line, ended)] = told
    first = int(line.split("misses steps ")[1].split(" on: the disk is too slow, 4e+06 bytes")[0])
    assert 10 * SAMPLES < first < 20 * SAMPLES
    assert first % SAMPLES == 0
    assert not ended
    disk.take()
    buffered.put([], patient=True)
    with buffered._room:
        assert buffered._room.wait_for(lambda: buffered.waiting == 0, PATIENCE)
    for number in range(40, 50):
        buffered.put(chunk(number, revision=1))
    buffered.close().result(PATIENCE)
    missing = f"{tmp_path / 'run'} misses steps {first} to {40 * SAMPLES - 1}: the disk is too slow, 4e+06 bytes"
    assert len(told) == 2
    assert told[1][0].startswith(missing)
    before = read_bag(disk.file())
    np.testing.assert_array_equal(before.steps, np.arange(first))  # all up to the gap
    assert [found.revision for found in before.states] == [0, 1]
    after = read_bag(tmp_path / "run" / "run_1.mcap")
    np.testing.assert_array_equal(after.steps, np.arange(40 * SAMPLES, 50 * SAMPLES))
    assert after.states[0].message.startswith(missing)
    assert (after.states[0].first_step, after.states[0].revision) == (40 * SAMPLES, 1)
    assert [(item.revision, item.step) for item in after.info.inputs] == [(0, 0), (1, 30 * SAMPLES)]


def test_what_is_lost_at_the_end_is_told_too(begin, chunk, told, tmp_path):
    bag, buffered = begin(1_000_000)
    disk = SlowDisk(bag)
    for number in range(20):
        buffered.put(chunk(number))
    closing = buffered.close()
    disk.take()
    closing.result(PATIENCE)
    disk.file()
    assert [f"to {20 * SAMPLES - 1}" in line for line, _ in told] == [False, True]


def test_who_is_patient_loses_nothing(begin, chunk, told, tmp_path):
    bag, buffered = begin(1_000_000)
    disk = SlowDisk(bag)
    threading.Timer(0.2, disk.take).start()
    for number in range(40):
        buffered.put(chunk(number), patient=True)
        assert buffered.waiting <= 1_000_000
    buffered.close().result(PATIENCE)
    assert told == []
    np.testing.assert_array_equal(read_bag(disk.file()).steps, np.arange(40 * SAMPLES))


@pytest.mark.slow
def test_changes_without_end_before_a_disk_that_stands_end_the_recording(begin, chunk, state, told, tmp_path):
    bag, buffered = begin(1_000_000)
    disk = SlowDisk(bag)
    for number in range(10):
        buffered.put(chunk(number))
    for number in range(10_000):
        buffered.put(state(10, revision=number))
        assert buffered.waiting <= 1_000_000 + RESERVE
        if told[-1][1]:
            break
    assert number > 500
    assert told[-1][0].endswith("ends here: the disk does not respond, and the buffer is full")
    disk.take()
    assert len(read_bag(disk.file())) >= 3 * SAMPLES


@pytest.mark.parametrize("gone", ["file", "folder"])
def test_a_bag_that_is_removed_ends_the_recording(begin, chunk, told, tmp_path, gone):
    _, buffered = begin()
    buffered.put(chunk(0))
    buffered.put(chunk(1))
    with buffered._room:
        assert buffered._room.wait_for(lambda: buffered.waiting == 0, PATIENCE)
    if gone == "file":
        (tmp_path / "run" / "run_0.mcap").unlink()
    else:
        shutil.rmtree(tmp_path / "run")
    buffered.put(chunk(2))
    buffered.put(chunk(3))
    with pytest.raises(RecordingError, match=r"cannot be written further \(run_0.mcap has been removed\)"):
        buffered.close().result(PATIENCE)
    [(line, ended)] = told
    assert ended
    assert "has been removed" in line
    _, again = begin(name="again")
    again.put(chunk(4))
    again.close().result(PATIENCE)
    assert len(read_bag(tmp_path / "again")) == SAMPLES


def test_what_nobody_wants_leaves_nothing(begin, tmp_path):
    _, buffered = begin()
    buffered.discard().result(PATIENCE)
    assert list(tmp_path.iterdir()) == []


def test_who_keeps_time_waits_for_the_disk_now_and_then(begin, chunk, monkeypatch):
    synced, fdatasync = [], os.fdatasync

    def sync(number):
        fdatasync(number)
        synced.append(number)

    monkeypatch.setattr("wheelset_track_sim.bags.bag_file.os.fdatasync", sync)
    monkeypatch.setattr("wheelset_track_sim.bags.buffered.SYNC_PERIOD", 0.0)
    _, buffered = begin()
    buffered.put(chunk(0), patient=True)
    buffered.split().result(PATIENCE)
    assert synced == []
    buffered.put(chunk(1))
    buffered.close().result(PATIENCE)
    assert len(synced) == 1
