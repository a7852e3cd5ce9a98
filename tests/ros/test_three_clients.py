"""Three processes ask a node for anything at once: it answers all, and each accepted speed is the revision it said.

``make endurance SECONDS=600`` goes on for ten minutes.
"""

import json
import os
import signal
import subprocess
import sys
from collections import Counter, defaultdict

import pytest

from support.paths import ROOT

SECONDS = float(os.environ.get("WHEELSET_TRACK_SIM_ENDURANCE", "8"))
"""For which the clients ask, s of the wall."""
CLIENTS = 3

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600 + 2 * SECONDS)]


@pytest.fixture
def ask(domain, tmp_path):
    """Run the clients to their end; what each has printed, a line of JSON each."""
    path = os.pathsep.join([str(ROOT / "tests"), str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(tmp_path / "log"),
        "PYTHONPATH": path,
    }

    def ask():
        files = [(tmp_path / f"client_{seed}").open("w+") for seed in range(CLIENTS)]
        processes = [
            subprocess.Popen(
                [sys.executable, "-m", "support.random_client", str(seed), str(SECONDS)],
                env=environment,
                stdout=file,
                stderr=subprocess.PIPE,
                text=True,
            )
            for seed, file in enumerate(files)
        ]
        told = [process.communicate()[1] for process in processes]
        assert [process.returncode for process in processes] == [0] * CLIENTS, "\n".join(told)
        found = []
        for file in files:
            file.seek(0)
            found.append([json.loads(line) for line in file])
            file.close()
        return found

    return ask


def run_of(message):
    """The run that a message is of, by the time of its step 0, ms."""
    stamp = message.header.stamp.sec * 1000 + message.header.stamp.nanosec * 1e-6
    return round(stamp - 1e3 * message.time)


def test_no_hang_no_traceback_no_wrong_revision(start, client, ask, tmp_path):
    summaries = client.collect("summary", "LoadSummary")
    states = client.collect("state", "SimulationState", latched=True)
    node = start(scenario="undamaged", record__directory=tmp_path / "bags", acceleration=5.0)
    client.until(lambda: summaries and states)
    told = ask()
    calls = sum((Counter(lines.pop()["calls"]) for lines in told), Counter())
    accepted = [line for lines in told for line in lines]
    assert client.state() in {"unconfigured", "inactive", "active"}  # it answers still
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors + node.output
    assert len({line["speed"] for line in accepted}) == len(accepted)

    chunks, begun = {}, {}
    for chunk in summaries:
        before = chunks.get(run_of(chunk))
        if before is not None:
            assert chunk.first_step >= before.first_step + before.samples
            assert chunk.revision >= before.revision
        chunks[run_of(chunk)] = chunk
    shown = defaultdict(list)
    for state in states:
        key = (run_of(state), state.revision)
        assert begun.setdefault(key, state.first_step) <= state.first_step
        shown[state.speed_set_point].append((state.first_step, state.revision))
    exact = 0
    for line in accepted:
        seen = shown.get(line["speed"])  # none: another speed, or the end of the run, came before its step
        answered = (line["step"], line["revision"])
        if seen and seen[0][0] > 0:  # otherwise a new run began with it
            assert seen[0] == answered
            exact += 1
    print(f"\n{sum(calls.values())} calls of {len(told)} clients: {dict(calls)}")
    print(f"{len(accepted)} speeds accepted, {exact} of them seen to come into force as answered, {len(chunks)} runs")
    assert exact or SECONDS < 60
