"""Recordings of a running node: bounds, snapshots, disks that are full, bags that are taken away, kill -9."""

import ctypes
import os
import resource
import shutil
import signal
import subprocess

import numpy as np
import pytest

from support.plain_scan import LARGEST_LOSS, Scan
from wheelset_track_sim.bags import read_bag

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

ERROR = bytes([2])


class Recordings:
    """What a client sees of a node's recordings."""

    def __init__(self, client):
        from diagnostic_msgs.msg import DiagnosticArray

        self.client = client
        self.forces = client.collect("contact_forces", "ContactForces")
        self.states = client.collect("state", "SimulationState", latched=True)
        self.impacts = client.collect("impacts", "WheelImpact")
        self.status = []
        client.node.create_subscription(DiagnosticArray, "/diagnostics", self._take, 10)

    def _take(self, array):
        with self.client.arrived:
            self.status += [item for item in array.status if item.name.endswith(": recording")]
            self.client.arrived.notify_all()

    def until_failed(self, why):
        self.client.until(lambda: self.status and self.status[-1].level == ERROR and why in self.status[-1].message)
        self.client.until(lambda: self.states[-1].recording == "")
        seen = len(self.forces)
        self.client.until(lambda: len(self.forces) > seen + 3)  # the stream goes on

    def start(self, name):
        from wheelset_track_msgs.srv import StartRecording

        return self.client.call("start_recording", StartRecording, again=False, name=name)

    def trigger(self, service):
        return self.client.trigger(service)

    def run_on(self, seconds):
        self.client.until(lambda: self.forces)
        due = self.forces[-1].time + seconds
        self.client.until(lambda: self.forces[-1].time > due)


@pytest.fixture
def recordings(client):
    return Recordings(client)


def test_bounds_and_snapshots_as_parameters_say(start, client, recordings, tmp_path):
    folder = {"record__directory": tmp_path, "record__name": "parts", "record__on_start": "true"}
    start(scenario="damage_wheel_1", real_time_factor=4.0, record__max_duration=1.0, **folder)
    recordings.run_on(2.5)
    refused = client.set(record__max_size=5)
    assert not refused.successful
    assert refused.reason == "record.max_size = 5 bytes is out of range: give at least 1e+06 bytes, or 0 for no limit"
    assert "set record.mode to snapshot" in recordings.trigger("take_snapshot").message
    assert recordings.trigger("stop_recording").success
    parts = sorted((tmp_path / "parts").glob("*.mcap"))
    assert len(parts) >= 3
    whole = read_bag(tmp_path / "parts")
    np.testing.assert_array_equal(whole.steps, np.arange(len(whole)))
    for part in map(read_bag, parts):
        assert part.states[0].first_step == part.steps[0]
        assert part.info.inputs

    settings = {"record__mode": "snapshot", "record__snapshot_duration": 0.3, "record__snapshot_after": 0.1}
    assert client.set(atomically=True, **settings).successful
    assert recordings.start("taken").success
    recordings.run_on(1.0)
    assert "nothing to split" in recordings.trigger("split_recording").message
    assert client.set(impact__threshold=4e6).successful  # there is none any more
    recordings.run_on(1.0)
    taken = recordings.trigger("take_snapshot")
    assert taken.success
    assert recordings.trigger("stop_recording").message == str(tmp_path / "taken")
    snapshots = sorted((tmp_path / "taken").iterdir(), key=lambda path: int(path.name.rpartition("_")[2]))
    assert str(snapshots[-1]) == taken.message
    steps = {impact.step for impact in recordings.impacts}
    assert len(snapshots) >= 2
    for path in snapshots:
        found = read_bag(path)
        assert found.states[0].first_step == found.steps[0]
        assert path == snapshots[-1] or int(path.name.rpartition("_")[2]) in steps
    assert found.time[-1] - found.time[0] == pytest.approx(0.3, abs=0.1)


class SmallDisk:
    """A folder that takes 3 MB: a disk of its own where that is allowed, else a limit on the files of the process."""

    size = 3_000_000

    def __init__(self, path, mounted):
        self.path, self.mounted = path, mounted

    def limit(self, process):
        if not self.mounted:
            resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (self.size, resource.RLIM_INFINITY))

    def free(self, process):
        shutil.rmtree(self.path / "first")
        if not self.mounted:
            resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))

    @property
    def error(self):
        return os.strerror(28 if self.mounted else 27)


@pytest.fixture
def small_disk(tmp_path):
    path = tmp_path / "disk"
    path.mkdir()
    libc = ctypes.CDLL(None, use_errno=True)
    mounted = libc.mount(b"tmpfs", bytes(path), b"tmpfs", 0, f"size={SmallDisk.size}".encode()) == 0
    yield SmallDisk(path, mounted)
    if mounted:
        subprocess.run(["umount", "--lazy", str(path)], check=True)


@pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="needs limits of another process")
def test_a_full_disk_ends_the_recording_and_when_there_is_room_another_begins(start, recordings, small_disk):
    """What is on the full disk can be read up to its last chunk: the index found room."""
    node = start(scenario="damage_wheel_1", record__directory=small_disk.path)
    recordings.run_on(0.1)
    small_disk.limit(node.process)
    assert recordings.start("first").success
    recordings.until_failed(small_disk.error)
    recorded = read_bag(small_disk.path / "first")
    np.testing.assert_array_equal(np.diff(recorded.steps), 1)
    assert len(recorded) > 5000
    small_disk.free(node.process)
    assert recordings.start("second").success
    recordings.run_on(0.2)
    assert recordings.trigger("stop_recording").success
    assert len(read_bag(small_disk.path / "second")) > 5000
    assert node.signal(signal.SIGINT) == 0
    assert small_disk.error in node.errors


def test_a_bag_that_is_taken_away_is_told(start, recordings, tmp_path):
    start(scenario="damage_wheel_1", record__directory=tmp_path, record__on_start="true", record__name="run")
    recordings.run_on(0.2)
    shutil.rmtree(tmp_path / "run")
    recordings.until_failed("run_0.mcap has been removed")
    assert recordings.start("run").success
    recordings.run_on(0.2)
    assert recordings.trigger("stop_recording").success
    assert "exists already" in recordings.start("run").message
    recordings.until_failed("not started: ")
    assert len(read_bag(tmp_path / "run")) > 5000


def test_a_killed_node_leaves_all_but_the_last_moment(start, recordings, tmp_path):
    bag = {"record__directory": tmp_path, "record__on_start": "true", "record__name": "run"}
    # Without memory shared with others, which nobody takes away behind a process that is killed.
    node = start(scenario="damage_wheel_1", env={"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}, **bag)
    recordings.run_on(1.0)
    node.process.kill()
    node.wait()
    last = recordings.forces[-1]
    found = Scan(tmp_path / "run")
    np.testing.assert_array_equal(found.steps, np.arange(len(found.steps)))
    assert last.time + len(last.wheel_1) * last.step_period - found.end <= LARGEST_LOSS
