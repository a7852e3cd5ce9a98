"""kill -9 at random moments: what a plain scan finds is whole, hardly anything is missing, and all of it recovered."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from support.paths import ROOT
from support.plain_scan import LARGEST_LOSS, Scan
from wheelset_track_sim.bags import Damage, read_bag
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.errors import RecordingError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

pytestmark = pytest.mark.slow

PATIENCE = 240.0


def kill_recorders(folder, count, seed):
    """Bags of recorders that were killed at random moments, each with the simulated time that it had been given."""
    # As a module: as a script its folder, which has a numbers.py, would come before the standard library.
    done = subprocess.run(
        [sys.executable, "-m", "support.killed_recorder", str(folder), str(count), str(seed)],
        cwd=ROOT / "tests",
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def simulated(duration):
    """The run that all of them recorded, by step, somewhat longer."""
    simulator = Simulator(load_scenario("damage_wheel_1"))
    return simulator.advance(round((duration + 0.2) / simulator.step_period))


def assert_recovered(path, out, undisturbed):
    """What is recovered opens everywhere, and is what was simulated, bit by bit."""
    steps = Scan(path).steps
    if not len(steps):  # killed before the first chunk
        with pytest.raises(RecordingError, match="holds nothing that can be saved"):
            recover(path, out)
        return
    found = recover(path, out)
    recording = read_bag(out)
    np.testing.assert_array_equal(recording.steps, steps)
    assert recording.forces.tobytes() == undisturbed.forces[steps].tobytes()
    assert recording.stresses.tobytes() == undisturbed.stresses[steps].tobytes()
    assert recording.info.scenario_name == "damage_wheel_1"
    assert {"it was not closed"} >= {loss.reason for loss in found.losses if isinstance(loss, Damage) and not loss.end}
    with AnyReader([out]) as reader:
        assert reader.message_count == found.messages == sum(1 for _ in reader.messages())
    for file in [out] if out.is_file() else out.glob("*.mcap"):
        with file.open("rb") as stream:
            assert sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages()) > 0


@pytest.mark.parametrize("count", [3, pytest.param(50, marks=pytest.mark.timeout(600))])
def test_of_a_recorder_that_is_killed_hardly_anything_is_missing(tmp_path, count):
    killed = kill_recorders(tmp_path, count, seed=count)
    assert len(killed) == count
    undisturbed = simulated(max(handed_over for _, handed_over in killed))
    for number, (path, handed_over) in enumerate(killed):
        assert_recovered(Path(path), tmp_path / f"new_{number}{('', '.mcap')[number % 2]}", undisturbed)
        found = Scan(Path(path))
        np.testing.assert_array_equal(found.steps, 1 + np.arange(len(found.steps)))
        assert handed_over - found.end <= LARGEST_LOSS, path
        assert found.first[0] in ("SimulationState", None)  # a file that has just begun
        assert len(found.infos) == len(found.first)
        assert {info.scenario_name for info in found.infos} == {"damage_wheel_1"}
        files = {file.name for file in Path(path).glob("*.mcap")}
        named = set(re.findall(r"bag_\d+_\d+\.mcap", (Path(path) / "metadata.yaml").read_text()))
        assert named <= files
        assert files - named <= {f"{Path(path).name}_{len(files) - 1}.mcap"}  # one that has just begun, which is empty
        assert files == named or found.first[-1] is None


def test_run_that_is_killed_leaves_what_it_had_recorded(tmp_path):
    bag = tmp_path / "run.mcap"
    command = [sys.executable, "-m", "wheelset_track_sim", "run", "damage_wheel_1", "--duration", "1000"]
    process = subprocess.Popen([*command, "--out", str(bag)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    limit = time.monotonic() + PATIENCE
    while not (bag.exists() and bag.stat().st_size > 3_000_000):
        assert process.poll() is None
        assert time.monotonic() < limit
        time.sleep(0.01)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    found = Scan(bag)
    np.testing.assert_array_equal(found.steps, np.arange(len(found.steps)))
    assert found.end > 0.4
    assert_recovered(bag, tmp_path / "new", simulated(found.end))
    assert [state.first_step for state in found.states] == [0]
    [info] = found.infos
    assert info.inputs
