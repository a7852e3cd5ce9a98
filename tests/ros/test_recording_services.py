"""Recordings by service, as another process uses them."""

from pathlib import Path

import numpy as np
import pytest

from support.service_calls import assert_gap_free, end
from wheelset_track_sim.bags import read_bag

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


def test_recordings_start_split_and_stop_while_it_streams(start, client, services, forces, states, tmp_path):
    node = start(scenario="damage_wheel_1", record__directory=tmp_path, chunk_duration=0.02)
    client.until(lambda: len(forces) > 5 and states)
    assert services.trigger("stop_recording").message == "nothing is being recorded: start a recording first"
    assert not services.trigger("split_recording").success
    answer = services.record("day 1/run")
    assert (answer.success, answer.message, answer.path) == (True, "", str(tmp_path / "day 1" / "run"))
    first = answer.first_step
    client.until(lambda: states[-1].recording == answer.path)
    again = services.record("other")
    assert (again.success, again.path) == (False, answer.path)
    assert "is being recorded: stop it first" in again.message
    files = ["run_0.mcap"]
    for number in (1, 2):
        seen = len(forces)
        client.until(lambda seen=seen: len(forces) > seen + 10)
        split = services.trigger("split_recording")
        assert split.success
        assert split.message == str(tmp_path / "day 1" / "run" / f"run_{number}.mcap")
        files.append(f"run_{number}.mcap")
    assert services.trigger("pause").success
    assert services.trigger("resume").success
    assert services.speed(30.0).success
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 10)
    stopped = services.trigger("stop_recording")
    assert (stopped.success, stopped.message) == (True, answer.path)
    client.until(lambda: states[-1].recording == "")
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 3)  # it streams on
    unnamed = services.record()
    assert unnamed.success
    assert Path(unnamed.path).parent == tmp_path
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 3)
    end(node)
    assert_gap_free(forces)

    recorded = read_bag(tmp_path / "day 1" / "run")
    assert recorded.steps[0] == first
    np.testing.assert_array_equal(np.diff(recorded.steps), 1)
    received = {chunk.first_step: chunk for chunk in forces}
    part = received[first]
    np.testing.assert_array_equal(part.wheel_1, recorded.forces[: len(part.wheel_1), 0])
    assert recorded.states[0].first_step == first
    assert recorded.states[-1].revision == 1
    alone = [read_bag(tmp_path / "day 1" / "run" / file) for file in files]
    assert sum(len(part) for part in alone) == len(recorded)
    for part in alone:  # each file tells what it holds
        assert part.states[0].first_step == part.steps[0]
        assert part.states[0].recording == answer.path
    assert read_bag(unnamed.path).steps[0] == unnamed.first_step > recorded.steps[-1]


def test_bags_over_ros_stay_below_the_folder(start, client, services, forces, tmp_path):
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / "link").symlink_to(tmp_path)
    node = start(scenario="undamaged", record__directory=tmp_path / "recordings")
    client.until(lambda: forces)
    for name in ("../run", "a/../../run", str(tmp_path / "run"), "link/run", ".", "~/../run"):
        answer = services.record(name)
        assert (answer.success, answer.path) == (False, "")
        assert "points outside" in answer.message
    assert "200" in services.record("x" * 100_000).message
    assert "cannot be printed" in services.record("a\nb").message
    (tmp_path / "recordings" / "taken").mkdir()
    assert "exists already" in services.record("taken").message
    assert sorted(path.name for path in tmp_path.rglob("*") if path.suffix == ".mcap") == []
    assert services.record("run").success
    end(node)
