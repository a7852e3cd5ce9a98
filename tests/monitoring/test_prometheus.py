"""Metrics over real HTTP, read by Prometheus' own parser."""

import sys
import urllib.error
import urllib.request

import numpy as np
import pytest

from wheelset_track_sim.bags.messages import fatigue_message
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.live.run_messages import Events
from wheelset_track_sim.live.stream import Timing
from wheelset_track_sim.monitoring.prometheus import Endpoint, Metrics
from wheelset_track_sim.monitoring.status import Status
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.impacts import Impact
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.samples.turns import TurnPeaks
from wheelset_track_sim.verdict.limit_set import Level


def scraped(endpoint):
    """Samples by name and labels."""
    from prometheus_client.parser import text_string_to_metric_families

    with urllib.request.urlopen(f"http://127.0.0.1:{endpoint.port}/metrics", timeout=20) as answer:
        assert answer.headers["Content-Type"].startswith("text/plain")
        text = answer.read().decode()
    found = {}
    for family in text_string_to_metric_families(text):
        assert family.documentation, family.name
        for sample in family.samples:
            found[(sample.name, *(value for _, value in sorted(sample.labels.items())))] = sample.value
    return found


@pytest.fixture
def metrics():
    pytest.importorskip("prometheus_client")
    return Metrics()


@pytest.fixture
def endpoint(metrics):
    endpoint = Endpoint(metrics, 0)
    yield endpoint
    endpoint.close()


def block(first=0):
    forces = np.full((100, 2), 98e3)
    forces[40:43, 0] = 0.0
    return SampleBlock(first, 0.0, 1e-3, 20.0, 0.0, 7, forces, np.zeros((100, 1, 6)), ("A1",))


def turn(number, force):
    return TurnPeaks(number, (force, 101e3), (66e6,))


def test_what_is_served_is_what_was_pushed(metrics, endpoint):
    before = scraped(endpoint)
    assert before["wheelset_impacts_total", "wheel_1"] == 0.0
    impact = Impact(0, 1, 0.0, 20.0, 0.0, 0, 0.0, 3e5, 98e3, 0.0, 0.0, 2e5)
    for first, turns in ((0, ()), (100, (turn(1, 290e3), turn(2, 120e3)))):
        item = block(first)
        metrics.push(item, summarise(item), Events([impact], turn(2, 120e3), turns), Timing(2.5, 0.25))
    metrics.set_levels([Status("wheel_1", Level.WARN, ""), Status("stress A1", Level.OK, "")])
    found = scraped(endpoint)
    assert found["wheelset_contact_force_peak_newtons", "wheel_1"] == 120e3
    assert found["wheelset_contact_force_peak_newtons", "wheel_2"] == 101e3
    assert found["wheelset_axle_stress_peak_pascals", "A1"] == 66e6
    assert found["wheelset_impacts_total", "wheel_1"] == 2.0
    assert found["wheelset_impacts_total", "wheel_2"] == 0.0
    assert found["wheelset_contact_loss_seconds_total", "wheel_1"] == pytest.approx(6e-3)
    assert found["wheelset_steps_total",] == 200.0
    assert found["wheelset_simulated_seconds_total",] == pytest.approx(0.2)
    assert found["wheelset_turns_total",] == 2.0
    assert found["wheelset_speed_meters_per_second",] == 20.0
    assert found["wheelset_real_time_factor",] == 2.5
    assert found["wheelset_lag_seconds",] == 0.25
    assert found["wheelset_revision",] == 7.0
    assert found["wheelset_status_level", "wheel_1"] == 1.0
    assert found["wheelset_turn_peak_force_newtons_bucket", "125000.0", "wheel_1"] == 1.0
    assert found["wheelset_turn_peak_force_newtons_bucket", "300000.0", "wheel_1"] == 2.0
    assert found["wheelset_turn_peak_force_newtons_sum", "wheel_1"] == 410e3


def test_fatigue_is_served_at_the_worst_angle(metrics, endpoint):
    damage = np.array([[1e-9, 1e-10], [3e-9, 4e-10]])  # by angle and rule
    fields = {"nodes": ["A1"], "rules": ["elementary", "haibach"], "damage": damage.ravel(), "ratio": [2.5]}
    report = fatigue_message(1.0, 0, {**fields, "amplitude": [80e6], "distance": 25.0})
    metrics.push(block(), summarise(block()), Events([], turn(0, 1.0), (), report), Timing(1.0, 0.0))
    found = scraped(endpoint)
    assert found["wheelset_axle_damage", "A1", "elementary"] == 3e-9
    assert found["wheelset_axle_damage", "A1", "haibach"] == 4e-10
    assert found["wheelset_axle_damage_ratio", "A1"] == 2.5
    assert found["wheelset_rotating_amplitude_pascals", "A1"] == 80e6
    assert found["wheelset_fatigue_distance_meters",] == 25.0


def test_two_runs_have_metrics_of_their_own(metrics, endpoint):
    other = Metrics()
    item = block()
    other.push(item, summarise(item), Events([], turn(0, 1.0)), Timing(1.0, 0.0))
    assert scraped(endpoint)["wheelset_steps_total",] == 0.0


def test_a_port_in_use_is_refused(metrics, endpoint):
    with pytest.raises(InputError, match=f"prometheus.port = {endpoint.port} on 127.0.0.1 cannot be served"):
        Endpoint(metrics, endpoint.port)


def test_closed_is_closed_and_the_port_is_free_again(metrics):
    endpoint = Endpoint(metrics, 0)
    port = endpoint.port
    endpoint.close()
    endpoint.close()
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5)
    Endpoint(metrics, port).close()


def test_without_prometheus_client_it_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "prometheus_client", None)
    with pytest.raises(InputError, match="prometheus_client is not installed: install it"):
        Metrics()
