"""Outputs of the node for monitoring stacks: ``/diagnostics``, impacts, metrics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from ..live.run_messages import Events
from ..live.stream import Timing
from ..monitoring.monitor import Monitor
from ..monitoring.prometheus import Endpoint, Metrics
from ..monitoring.status import Status
from ..samples.block import SampleBlock
from ..samples.summary import Summary
from ..simulation.simulator import Simulator
from ..verdict.limit_set import Level, load_limits
from .conversions import diagnostics
from .parameters import Parameters, Watching

PERIOD = 1.0
"""Wall time from report to report, s; changes for the worse are reported at once."""


class Monitoring:
    """Watches a node from its start to its end, also while it has no models; methods may be called in any thread."""

    def __init__(self, node: Node, parameters: Parameters, others: Callable[[], list[Status]]) -> None:
        """For ``node``; ``others`` says how all is that is not of its run, such as its bag."""
        self._node, self._parameters, self._others = node, parameters, others
        self._name = node.get_fully_qualified_name().lstrip("/")
        self._simulation = Status("simulation", Level.OK, "unconfigured")
        self._simulator: Simulator | None = None
        self._monitor: Monitor | None = None
        self._metrics: Metrics | None = None
        self._endpoint: Endpoint | None = None
        self._pause = ""
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        # The wall's clock, also where the node follows another one; a group of its own, or it waits for transitions.
        group, clock = MutuallyExclusiveCallbackGroup(), Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(PERIOD, self.report, callback_group=group, clock=clock)

    def building(self, stage: str, fraction: float) -> None:
        """Models are being built."""
        before = self._simulation.message
        self._simulation = Status("simulation", Level.OK, f"configuring: {stage}, {100 * fraction:.0f} %")
        if stage not in before:
            self.report()

    def begin(self, simulator: Simulator, real_time_factor: float) -> None:
        """A run begins, paused; raises InputError if its metrics cannot be served."""
        self._clear()
        settings = self._parameters.watching({})
        port = self._parameters["prometheus.port"]
        if port:
            self._metrics = Metrics()
            self._endpoint = Endpoint(self._metrics, port, self._parameters["prometheus.address"])
        self._simulator = simulator
        self._monitor = Monitor(
            simulator.scenario.output.stress_nodes,
            settings.impact.threshold,
            settings.limits,
            simulator.steps_per_revolution,
            simulator.constant_stress,
            limit_set=load_limits(self._parameters["limits"]),
        )
        self._monitor.wanted = real_time_factor
        self.pause("configured, not active")

    def change(self, settings: Watching, real_time_factor: float) -> None:
        """Settings that are in force from the next chunk on."""
        if self._monitor is not None:
            self._monitor.threshold, self._monitor.limits = settings.impact.threshold, settings.limits
            self._monitor.wanted = real_time_factor

    def run(self) -> None:
        """The run continues."""
        self._pause = ""
        self._tell("running")

    def pause(self, why: str) -> None:
        """The run is paused, until ``run``."""
        self._pause = why
        self._tell(why)

    def fail(self, why: str) -> None:
        """The run cannot go on, or there is none."""
        self._pause = why
        self._tell(why, Level.ERROR)

    def push(self, block: SampleBlock, summary: Summary, events: Events, timing: Timing) -> None:
        """Take the latest block of the simulator, with the impacts and turns in it."""
        assert self._monitor is not None
        assert self._simulator is not None
        if self._metrics is not None:
            self._metrics.push(block, summary, events, timing)
        if self._monitor.push(block, summary, events, timing, self._simulator.in_force):
            self.report()

    def end(self, told: str = "unconfigured") -> None:
        """There is no run any more."""
        self._clear()
        if self._simulation.level == Level.OK:
            self._tell(told)

    def report(self) -> None:
        """Publish how all is."""
        monitor, simulator, metrics = self._monitor, self._simulator, self._metrics
        statuses = [self._simulation, *self._others()]
        if monitor is not None and simulator is not None:
            statuses += monitor.stale(self._pause) if self._pause else monitor.report()
        if metrics is not None:
            metrics.set_levels(statuses)
        self._publisher.publish(diagnostics(statuses, self._name, self._node.get_clock().now().to_msg()))

    def _clear(self) -> None:
        if self._endpoint is not None:
            self._endpoint.close()
        self._simulator = self._monitor = self._metrics = self._endpoint = None

    def _tell(self, message: str, level: Level = Level.OK) -> None:
        simulator = self._simulator
        values: tuple[tuple[str, Any], ...] = ()
        if simulator is not None:
            scenario = simulator.in_force
            values = (("scenario", scenario.name), ("digest", simulator.digest), ("revision", simulator.revision))
        self._simulation = Status("simulation", level, message, tuple((key, str(value)) for key, value in values))
        self.report()
