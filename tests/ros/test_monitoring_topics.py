"""What a monitoring stack sees of the node: impacts, summary, /diagnostics, metrics, over the real middleware."""

import resource
import signal
import socket
import time
import urllib.request
from itertools import pairwise

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from wheelset_track_sim.scenario import load_scenario

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

OK, WARN, ERROR, STALE = b"\x00", b"\x01", b"\x02", b"\x03"
NODE = "wheelset_track_sim"
SUBJECTS = {
    "verdict",
    "simulation",
    "recording",
    "services",
    "wheel_1",
    "wheel_2",
    "stress A1",
    "stress B1",
    "stress C1",
    "pacing",
}
STATIC = load_scenario("damage_wheel_1").wheel_load
TURN = 2713


class Diagnostics:
    """What arrived on /diagnostics, with the wall time of arrival."""

    def __init__(self, client):
        from diagnostic_msgs.msg import DiagnosticArray

        self.found, self.client = [], client

        def take(message):
            with client.arrived:
                self.found.append((time.monotonic(), message))
                client.arrived.notify_all()

        client.node.create_subscription(DiagnosticArray, "/diagnostics", take, 500)

    def statuses(self, subject, since=0):
        """Statuses of a subject."""
        name = f"{NODE}: {subject}"
        return [status for _, array in self.found[since:] for status in array.status if status.name == name]

    def until(self, subject, condition):
        """The first status of a subject from now on that fulfils a condition."""
        since = len(self.found)
        self.client.until(lambda: any(condition(status) for status in self.statuses(subject, since)))
        return next(status for status in self.statuses(subject, since) if condition(status))


@pytest.fixture
def diagnostics(client):
    return Diagnostics(client)


def values(status):
    return {item.key: item.value for item in status.values}


def level(wanted):
    return lambda status: status.level == wanted


def test_impacts_are_those_of_the_forces_on_the_wire_and_in_the_bag(start, client, tmp_path):
    impacts = client.collect("impacts", "WheelImpact")
    forces = client.collect("contact_forces", "ContactForces")
    summaries = client.collect("summary", "LoadSummary")
    bag = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "run"}
    node = start(scenario="damage_wheel_1", **bag)
    client.until(lambda: forces and summaries)
    enough = max(forces[0].first_step, summaries[0].first_step) + 8 * TURN
    client.until(lambda: forces[-1].first_step > enough and summaries[-1].first_step > enough)
    client.until(lambda: impacts and impacts[-1].step > enough - TURN)
    assert node.signal(signal.SIGINT) == 0, node.errors
    first = forces[0].first_step
    force = np.concatenate([chunk.wheel_1 for chunk in forces])
    seen = [impact for impact in impacts if first + 100 <= impact.step < first + len(force) - 100]
    assert len(seen) >= 5
    for impact in seen:
        row = impact.step - first
        assert impact.wheel == impact.WHEEL_1
        assert impact.peak_force == force[row] == force[row - 100 : row + 100].max()
        assert impact.static_force == STATIC
        assert impact.dynamic_factor == impact.peak_force / STATIC > 2
        assert impact.threshold == 200e3
        assert impact.contact_loss > 0
        assert impact.position == pytest.approx(impact.step * 1e-3, rel=1e-9)
        assert min(impact.angle, 2 * np.pi - impact.angle) * 0.43175 < 0.060  # the damage is at angle 0
    steps = np.array([impact.step for impact in seen])
    np.testing.assert_allclose(np.diff(steps) / TURN, np.round(np.diff(steps) / TURN), atol=0.03)

    end = first + len(force)
    turns = [summary for summary in summaries if first + TURN <= summary.turns * TURN <= end]
    assert turns
    for summary in turns:
        rows = slice((summary.turns - 1) * TURN - first, summary.turns * TURN - first)
        assert summary.wheel_1_turn_max_force == force[rows].max()
        assert len(summary.turn_max_principal) == 3

    with AnyReader([tmp_path / "run"]) as reader:
        topic = [item for item in reader.connections if item.topic.endswith("/impacts")]
        recorded = [reader.deserialize(data, item.msgtype) for item, _, data in reader.messages(connections=topic)]
    by_step = {impact.step: impact for impact in recorded}
    for impact in impacts:
        assert by_step[impact.step].peak_force == impact.peak_force


def test_the_threshold_changes_while_the_node_runs(start, client):
    impacts = client.collect("impacts", "WheelImpact")
    forces = client.collect("contact_forces", "ContactForces")
    start(scenario="damage_wheel_1", impact__threshold=2e6)
    client.until(lambda: forces)
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 6)  # three turns
    assert impacts == []
    assert client.set(impact__threshold=250e3).successful
    client.until(lambda: len(impacts) >= 2)
    assert {impact.threshold for impact in impacts} == {250e3}
    refused = client.set(impact__threshold=-1.0)
    assert not refused.successful
    assert "impact.threshold" in refused.reason
    assert {chunk.revision for chunk in forces} == {0}  # what is watched is no matter of the scenario


def test_diagnostics_name_every_subject_once_a_second(start, client, diagnostics):
    start(scenario="damage_wheel_1")
    found = diagnostics.until("wheel_1", level(WARN))  # 200 kN is exceeded, 350 kN is not
    assert float(values(found)["peak_force_N"]) > 200e3
    assert "above the impact threshold of 200 kN" in found.message
    assert found.hardware_id == NODE
    assert diagnostics.until("wheel_2", level(OK))
    assert {status.name for status in diagnostics.found[-1][1].status} == {f"{NODE}: {name}" for name in SUBJECTS}
    began = len(diagnostics.found)
    client.until(lambda: len(diagnostics.found) >= began + 5)
    arrived = [at for at, _ in diagnostics.found[began : began + 5]]
    assert 0.1 < (arrived[-1] - arrived[0]) / 4 < 5.0  # once a second, on a machine that may be busy
    simulation = values(diagnostics.statuses("simulation")[-1])
    assert simulation["scenario"] == "damage_wheel_1"


def test_levels_follow_the_loads_and_the_limits(start, client, diagnostics):
    start(scenario="undamaged")
    assert diagnostics.until("wheel_1", level(OK))
    assert client.set(wheel_1__damage__a=0.030, wheel_1__damage__b=0.024, atomically=True).successful
    assert client.set(wheel_1__damage__h=0.002).successful
    assert diagnostics.until("wheel_1", level(WARN))
    assert client.set(diagnostics__force_error=210e3).successful
    assert "above the limit of 210 kN" in diagnostics.until("wheel_1", level(ERROR)).message
    assert client.set(atomically=True, diagnostics__stress_warn=50e6, diagnostics__stress_error=1e9).successful
    assert diagnostics.until("stress A1", level(WARN))
    assert client.set(wheel_1__damage__h=0.0).successful
    assert diagnostics.until("wheel_1", level(OK))
    crossed = client.set(diagnostics__stress_warn=1.1e9)
    assert not crossed.successful
    assert "diagnostics.stress_warn" in crossed.reason


def test_progress_of_the_models_and_the_lifecycle_are_told(start, client, diagnostics, tmp_path):
    node = start(scenario="undamaged", autostart="false", env={"WHEELSET_TRACK_SIM_CACHE": str(tmp_path / "empty")})
    assert diagnostics.until("simulation", level(OK)).message == "unconfigured"
    client.transition("configure")  # its answer may come later than a client waits
    client.wait_for_state("inactive")
    told = [status.message for status in diagnostics.statuses("simulation")]
    building = {message.partition(",")[0] for message in told if message.startswith("configuring: ")}
    assert len(building) >= 3, told  # wheelset, track, contact
    assert diagnostics.until("wheel_1", level(STALE)).message == "configured, not active"
    assert client.transition("activate")
    assert diagnostics.until("wheel_1", level(OK))
    assert diagnostics.statuses("simulation")[-1].message == "running"
    assert client.transition("deactivate")
    assert diagnostics.until("pacing", level(STALE)).message == "paused"
    assert client.transition("activate")
    assert diagnostics.until("pacing", lambda status: status.level != STALE)
    assert client.transition("deactivate")
    assert client.transition("cleanup")
    assert diagnostics.until("simulation", lambda status: status.message == "unconfigured")
    assert {status.name.partition(": ")[2] for status in diagnostics.found[-1][1].status} == {
        "simulation",
        "recording",
        "services",
    }
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors


def test_a_configuration_that_fails_is_an_error_with_its_reason(start, client, diagnostics):
    pytest.importorskip("prometheus_client")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        start(scenario="undamaged", autostart="false", prometheus__port=port)
        assert not client.transition("configure")
        assert str(port) in diagnostics.until("simulation", level(ERROR)).message


@pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="needs limits of another process")
def test_a_bag_that_cannot_be_written_any_more_is_an_error(start, client, diagnostics, tmp_path):
    """A limit on the size of files stands for a full disk."""
    forces = client.collect("contact_forces", "ContactForces")
    bag = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "full"}
    node = start(scenario="undamaged", **bag)
    assert diagnostics.until("recording", lambda status: status.message == f"to {tmp_path / 'full'}").level == OK
    written = sum(file.stat().st_size for file in (tmp_path / "full").iterdir())
    resource.prlimit(node.process.pid, resource.RLIMIT_FSIZE, (written + 100_000, resource.RLIM_INFINITY))
    assert "ended early" in diagnostics.until("recording", level(ERROR)).message
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 3)  # the stream is worth more than the bag


def test_a_node_that_cannot_keep_its_pace_says_so_and_recovers(start, client, diagnostics):
    """Wanted is more than any machine can do; then less, which is the recovery."""
    summaries = client.collect("summary", "LoadSummary")
    start(scenario="undamaged", real_time_factor=1000.0)
    found = diagnostics.until("pacing", level(ERROR))
    assert float(values(found)["lag_s"]) > 0
    assert float(values(found)["wanted_real_time_factor"]) == 1000.0
    client.until(lambda: any(summary.lag > 0 for summary in summaries))
    assert client.set(real_time_factor=0.5).successful
    assert diagnostics.until("pacing", level(OK))
    seen = len(summaries)
    client.until(lambda: len(summaries) > seen + 5)
    assert summaries[-1].lag < 1.0
    for before, after in pairwise(summaries[seen:]):
        assert after.first_step == before.first_step + before.samples


def free_port():
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        return holder.getsockname()[1]


def scrape(port):
    from prometheus_client.parser import text_string_to_metric_families

    with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=20) as answer:
        text = answer.read().decode()
    return {
        (sample.name, *(value for _, value in sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_metrics_are_served_while_there_is_a_run(start, client, diagnostics):
    pytest.importorskip("prometheus_client")
    port = free_port()
    summaries = client.collect("summary", "LoadSummary")
    node = start(scenario="damage_wheel_1", prometheus__port=port)
    client.until(lambda: summaries and summaries[-1].turns >= 3)
    before = scrape(port)
    seen = summaries[-1].first_step
    client.until(lambda: summaries[-1].first_step > seen + 2 * TURN)
    found = scrape(port)
    assert found["wheelset_steps_total",] >= before["wheelset_steps_total",] + TURN
    assert found["wheelset_impacts_total", "wheel_1"] > before["wheelset_impacts_total", "wheel_1"]
    assert found["wheelset_contact_force_peak_newtons", "wheel_1"] > 200e3
    assert found["wheelset_contact_force_peak_newtons", "wheel_2"] < 200e3
    diagnostics.until("wheel_1", level(WARN))
    assert scrape(port)["wheelset_status_level", "wheel_1"] == 1.0
    assert node.signal(signal.SIGINT) == 0, node.errors


def test_a_port_in_use_is_refused_in_one_line(start):
    pytest.importorskip("prometheus_client")
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        node = start(scenario="undamaged", prometheus__port=holder.getsockname()[1])
        assert node.wait() == 2
    assert "prometheus.port" in node.errors
    assert "Traceback" not in node.errors
