"""A node whose processor is taken away: it falls behind, says so, loses nothing, and catches up."""

import math
import os
import statistics
import subprocess
import sys
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import pytest

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

HOGS = 10
OK, WARN = 0, 1
SUBJECT = "wheelset_track_sim: pacing"


@contextmanager
def hogs(core):
    """Processes that leave little of a core to others."""
    code = f"import os; os.sched_setaffinity(0, {{{core}}})\nwhile True: pass"
    running = [subprocess.Popen([sys.executable, "-S", "-c", code], start_new_session=True) for _ in range(HOGS)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()


@pytest.fixture
def levels(client):
    """Levels of the pace as they arrive."""
    from diagnostic_msgs.msg import DiagnosticArray

    found = []

    def take(message):
        with client.arrived:
            found.extend(status.level[0] for status in message.status if status.name == SUBJECT)
            client.arrived.notify_all()

    client.node.create_subscription(DiagnosticArray, "/diagnostics", take, 500)
    return found


def pace(client, summaries, chunks=300):
    """Simulated over elapsed time of coming chunks."""
    seen = len(summaries)
    client.until(lambda: len(summaries) >= seen + chunks)
    return statistics.harmonic_mean(summary.real_time_factor for summary in summaries[seen:])


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs Linux to put processes on one core")
def test_a_node_under_full_load_falls_behind_says_so_and_recovers(start, client, levels):
    """On one core with ten others it wants less than it can do alone, and more than it gets."""
    summaries = client.collect("summary", "LoadSummary")
    node = start(scenario="undamaged", real_time_factor=0.0, diagnostics__lag_error=1000.0)
    client.until(lambda: summaries)
    core = min(os.sched_getaffinity(0))
    for task in Path(f"/proc/{node.process.pid}/task").iterdir():
        os.sched_setaffinity(int(task.name), {core})
    alone = pace(client, summaries)

    with hogs(core):
        crowded = pace(client, summaries)
        assert crowded < alone / 2  # it is one of eleven on that core
        assert client.set(real_time_factor=round(math.sqrt(alone * crowded), 2)).successful
        began = len(levels)
        client.until(lambda: max(levels[began:], default=OK) >= WARN)
        client.until(lambda: summaries[-1].lag > 0.2)

    began = len(levels)
    client.until(lambda: levels[began:] and levels[-1] == OK)
    assert summaries[-1].lag < 0.2
    for before, after in pairwise(summaries[-500:]):
        assert after.first_step == before.first_step + before.samples
