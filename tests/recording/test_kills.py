"""kill -9 at random moments: what a plain scan of the file finds is whole, and hardly anything is missing."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from plain_scan import LARGEST_LOSS, Scan

PATIENCE = 240.0


def kill_recorders(folder, count, seed):
    """Bags of recorders that were killed at random moments, each with the simulated time that it had been given."""
    script = Path(__file__).with_name("killed_recorder.py")
    done = subprocess.run(
        [sys.executable, str(script), str(folder), str(count), str(seed)],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.parametrize("count", [3, pytest.param(50, marks=[pytest.mark.slow, pytest.mark.timeout(600)])])
def test_of_a_recorder_that_is_killed_hardly_anything_is_missing(tmp_path, count):
    killed = kill_recorders(tmp_path, count, seed=count)
    assert len(killed) == count
    for path, handed_over in killed:
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


@pytest.mark.slow
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
    assert [state.first_step for state in found.states] == [0]
    [info] = found.infos
    assert info.inputs
