"""Metrics of a run as Prometheus reads them; needs ``prometheus_client`` (extra ``prometheus``)."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from socketserver import ThreadingMixIn
from typing import TYPE_CHECKING, Any
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer, make_server

from ..errors import InputError
from ..live.run_messages import Events
from ..live.stream import Timing
from ..samples.block import SampleBlock
from ..samples.summary import Summary
from ..scenario import WHEELS
from .status import Status

if TYPE_CHECKING:
    from prometheus_client import CollectorRegistry

FORCES = tuple(1e3 * force for force in (100, 125, 150, 175, 200, 250, 300, 350, 400, 500, 700, 1000))
"""Upper bounds of the histogram of peak forces, N."""


class Metrics:
    """Metrics of one run in a registry of their own."""

    def __init__(self) -> None:
        """Raises InputError if ``prometheus_client`` is not installed."""
        try:
            from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram
        except ImportError:
            raise InputError(
                "prometheus_client is not installed: install it (pip install prometheus_client), or set "
                "prometheus.port to 0"
            ) from None
        self.registry: CollectorRegistry = CollectorRegistry()

        def made(kind: Any, name: str, meaning: str, *labels: str, **options: Any) -> Any:
            return kind(f"wheelset_{name}", meaning, labels, registry=self.registry, **options)

        self._force = made(
            Gauge, "contact_force_peak_newtons", "Largest contact force in the last turn of the wheel", "wheel"
        )
        self._forces = made(
            Histogram, "turn_peak_force_newtons", "Largest contact forces of the turns", "wheel", buckets=FORCES
        )
        self._stress = made(
            Gauge, "axle_stress_peak_pascals", "Largest maximum principal stress in the last turn", "node"
        )
        self._loss = made(Counter, "contact_loss_seconds", "Simulated time without contact", "wheel")
        self._impacts = made(Counter, "impacts", "Impacts above the threshold", "wheel")
        self._steps = made(Counter, "steps", "Steps of the simulation")
        self._simulated = made(Counter, "simulated_seconds", "Simulated time")
        self._turns = made(Counter, "turns", "Complete turns of the wheels")
        self._speed = made(Gauge, "speed_meters_per_second", "Running speed")
        self._factor = made(Gauge, "real_time_factor", "Simulated over elapsed time of the latest chunk")
        self._lag = made(Gauge, "lag_seconds", "Time behind the schedule")
        self._revision = made(Gauge, "revision", "Number of the accepted change in force")
        self._level = made(
            Gauge, "status_level", "Level of a subject: 0 is OK, 1 a warning, 2 an alarm, 3 stale", "subject"
        )
        self._damage = made(Gauge, "axle_damage", "Fatigue damage at the worst angle, by the S-N curve", "node", "rule")
        self._ratio = made(Gauge, "axle_damage_ratio", "The same over that without damaged wheels", "node")
        self._rotating = made(Gauge, "rotating_amplitude_pascals", "Largest rotating amplitude of the axle", "node")
        self._distance = made(Gauge, "fatigue_distance_meters", "Distance over which fatigue is counted")
        for wheel in WHEELS:  # counters are there from the start, or the first impact is no increase
            self._loss.labels(wheel)
            self._impacts.labels(wheel)

    def push(self, block: SampleBlock, summary: Summary, events: Events, timing: Timing) -> None:
        """Take in a block."""
        for wheel, load in zip(WHEELS, summary.wheels, strict=True):
            self._loss.labels(wheel).inc(load.contact_loss)
        for impact in events.impacts:
            self._impacts.labels(WHEELS[impact.wheel]).inc()
        for turn in events.turns:
            self._turns.inc()
            for wheel, force in zip(WHEELS, turn.forces, strict=True):
                self._forces.labels(wheel).observe(force)
                self._force.labels(wheel).set(force)
            for node, stress in zip(block.nodes, turn.principal, strict=True):
                self._stress.labels(node).set(stress)
        if events.fatigue is not None:
            self._set_fatigue(events.fatigue.fields)
        self._steps.inc(len(block))
        self._simulated.inc(len(block) * block.step_period)
        self._speed.set(block.speed)
        self._factor.set(timing.real_time_factor)
        self._lag.set(timing.lag)
        self._revision.set(block.revision)

    def _set_fatigue(self, report: Mapping[str, Any]) -> None:
        nodes, rules = report["nodes"], report["rules"]
        damage = report["damage"].reshape(len(nodes), -1, len(rules))
        for node, by_angle, ratio, amplitude in zip(nodes, damage, report["ratio"], report["amplitude"], strict=True):
            self._ratio.labels(node).set(ratio)
            self._rotating.labels(node).set(amplitude)
            for rule, harm in zip(rules, by_angle[by_angle[:, 0].argmax()], strict=True):
                self._damage.labels(node, rule).set(harm)
        self._distance.set(report["distance"])

    def set_levels(self, statuses: Iterable[Status]) -> None:
        """Take in the levels of a report."""
        for status in statuses:
            self._level.labels(status.name).set(status.level)


class _Server(ThreadingMixIn, WSGIServer):
    daemon_threads = True
    allow_reuse_address = True


class _Quiet(WSGIRequestHandler):
    timeout = 10.0

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002  the name is the base class's
        """Say nothing."""


class Endpoint:
    """``http://ADDRESS:PORT/metrics`` until it is closed."""

    def __init__(self, metrics: Metrics, port: int, address: str = "127.0.0.1") -> None:
        """Serve from now on; port 0 is one that is free. Raises InputError if the port cannot be had."""
        from prometheus_client import make_wsgi_app

        try:
            self._server = make_server(address, port, make_wsgi_app(metrics.registry), _Server, _Quiet)
        except (OSError, OverflowError) as reason:
            told = getattr(reason, "strerror", None) or reason
            raise InputError(f"prometheus.port = {port} on {address} cannot be served ({told}): give another") from None
        self._thread = threading.Thread(target=self._server.serve_forever, name="metrics", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Port that is served."""
        return int(self._server.server_port)

    def close(self) -> None:
        """Serve no more; closing again does nothing."""
        if self._thread.is_alive():
            self._server.shutdown()
            self._thread.join()
            self._server.server_close()
