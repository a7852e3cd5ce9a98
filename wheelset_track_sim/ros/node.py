"""The ROS 2 node: a managed (lifecycle) node around a simulator that runs in a thread of its own."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..errors import RecordingError, WheelsetTrackError
from ..monitoring.status import recording_status
from ..recording.messages import State, chunk_messages, impact_message, state_message
from ..recording.origin import state
from ..simulation.block import SampleBlock
from ..simulation.fleet import ModelPool
from ..simulation.simulator import Simulator
from ..simulation.streaming import Stream, Timing
from ..simulation.summary import summarise
from .monitoring import Monitoring
from .outputs import Outputs
from .parameters import Parameters
from .recorder import Recorder

NAME = "wheelset_track_sim"
RUNNING, PAUSED, FAILED = range(3)
"""Status in SimulationState."""
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class Interrupted(Exception):  # noqa: N818  no error: the node was told to end while it built its models
    """Stops the building of models."""


class SimulationNode(LifecycleNodeMixin, Node):  # type: ignore[misc]
    """A wheelset on a track that publishes contact forces and axle stresses while it runs.

    Configuring builds or loads the models, activating streams, deactivating pauses (the bag stays open), cleaning up
    frees the models and closes the bag. Topics are in ``outputs`` and ``monitoring``, parameters in ``parameters``.
    """

    def __init__(
        self, end: Callable[[Exception | None], None], name: str = NAME, models: ModelPool | None = None
    ) -> None:
        """``end`` is called when the node is through by itself; ``models`` are those of the nodes of one process.

        Raises InputError for parameters it cannot use.
        """
        Node.__init__(self, name)
        # Building models takes a while: the services of the lifecycle and of parameters must not queue behind it.
        LifecycleNodeMixin.__init__(self, callback_group=ReentrantCallbackGroup())
        self._end = end
        self._models = models or ModelPool()
        self._lock = threading.RLock()  # the scenario wanted, and the simulator that has it
        self._transition = threading.Lock()
        self._interrupted = False
        self._refusal: WheelsetTrackError | None = None
        self.lost: RecordingError | None = None
        """What ended a recording before its time."""
        self.parameters = Parameters(self)
        self._scenario, self._pace = self.parameters.changed({})
        self._simulator: Simulator | None = None
        self._stream: Stream | None = None
        self._state: State | None = None
        self._start_ns = 0
        self._outputs = Outputs(self, self.parameters.decimation({}))
        self._recorder = Recorder(self.get_fully_qualified_name())
        self._monitoring = Monitoring(self, self.parameters, lambda: recording_status(self._recorder.path, self.lost))
        self.add_on_set_parameters_callback(self._on_parameters)

    def autostart(self) -> None:
        """Configure and activate; what stands in the way ends the node."""
        try:
            started = self.trigger_configure() == SUCCESS and self.trigger_activate() == SUCCESS
        except Exception as failure:  # noqa: BLE001  another has sent the node through its states meanwhile
            self._end(failure)
            return
        if not started:
            self._end(self._refusal or WheelsetTrackError("the node did not start: see its log"))

    def on_configure(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Build or load the models and settle."""
        return self._guarded(self._configure, previous)

    def on_activate(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Stream, from where the run was paused."""
        return self._guarded(self._activate, previous)

    def on_deactivate(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Pause: no sample is lost."""
        return self._guarded(self._deactivate, previous)

    def on_cleanup(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Close the bag and free the models."""
        return self._guarded(self._release, previous)

    def on_shutdown(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Close the bag and free the models, from any state."""
        return self._guarded(self._release, previous)

    def on_error(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Begin anew, unconfigured."""
        return self._guarded(self._release, previous)

    def close(self) -> None:
        """End the run from outside of all callbacks: stop, close the bag."""
        self._interrupted = True
        with self._transition:  # models that are being built notice
            pass
        with suppress(Exception):  # a state without a way to shut down
            self.trigger_shutdown()
        self._release(None)

    def _guarded(self, step: Callable[[Any], None], previous: LifecycleState) -> TransitionCallbackReturn:
        """One transition: an error of ours is told in one line and fails it, any other is logged with its traceback."""
        self._refusal = None
        with self._transition:
            try:
                step(previous)
            except Interrupted:
                return FAILURE
            except WheelsetTrackError as refusal:
                self._refusal = refusal
                if isinstance(refusal, RecordingError):
                    self.lost = refusal
                self.get_logger().error(str(refusal))
                self._monitoring.fail(str(refusal))
                return FAILURE
            except Exception:
                self.get_logger().fatal(traceback.format_exc())
                raise
        return SUCCESS

    def _configure(self, previous: LifecycleState) -> None:
        with self._lock:
            scenario = self._scenario
        stages: set[str] = set()

        def progress(stage: str, fraction: float) -> None:
            if self._interrupted:
                raise Interrupted
            if stage not in stages:
                stages.add(stage)
                self.get_logger().info(stage)
            self._monitoring.building(stage, fraction)

        simulator = Simulator(scenario, progress, self._models.models(scenario, progress))
        with self._lock:
            if self._scenario != scenario:  # changed while the models were built
                simulator.apply(self._scenario)
            self._simulator = simulator
        self._start_ns = self.get_clock().now().nanoseconds
        self._monitoring.begin(simulator, self._pace.real_time_factor)
        self._outputs.create(simulator.scenario.output.stress_nodes)
        LifecycleNodeMixin.on_configure(self, previous)
        self._tell(state(simulator), PAUSED)

    def _activate(self, previous: LifecycleState) -> None:
        simulator = self._simulator
        if simulator is None or self._interrupted:
            raise Interrupted
        if simulator.next_step == 0:
            self._start_ns = self.get_clock().now().nanoseconds
            if self.parameters["record.on_start"]:
                folder, name = self.parameters["record.directory"], self.parameters["record.name"]
                self._recorder.start(folder, name, simulator, self._start_ns)
        LifecycleNodeMixin.on_activate(self, previous)
        self._tell(state(simulator), RUNNING)
        self.get_logger().info(
            f"streaming {simulator.scenario.name} from step {simulator.next_step} at {simulator.speed:g} m/s"
            + (f", recording to {self._recorder.path}" if self._recorder.path else "")
        )
        self._monitoring.run()
        self._stream = Stream(simulator, self._pace, self._deliver, self._on_end)
        self._stream.start()

    def _deactivate(self, previous: LifecycleState) -> None:
        self._stop_stream()
        if self._simulator is not None and self._state is not None and self._state.status != FAILED:
            self._tell(state(self._simulator), PAUSED)
            self._monitoring.pause("paused")
        LifecycleNodeMixin.on_deactivate(self, previous)

    def _release(self, previous: LifecycleState | None) -> None:
        self._stop_stream()
        with self._lock:
            self._simulator = None
        self._finish()
        self._outputs.destroy()
        path = self._recorder.path
        self._recorder.stop()
        if path:
            self.get_logger().info(f"recorded {path}")
        self._monitoring.end()

    def _stop_stream(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.stop()

    def _deliver(self, block: SampleBlock, timing: Timing) -> None:
        """In the stream's thread: record and publish a chunk, and before it the state if it has changed."""
        summary = summarise(block)
        seen = self._monitoring.push(block, summary, timing)
        messages = chunk_messages(
            block,
            self._start_ns,
            real_time_factor=timing.real_time_factor,
            lag=timing.lag,
            summary=summary,
            turn=seen.turn,
        )
        messages += [impact_message(impact, self._start_ns) for impact in seen.impacts]
        if self._simulator is not None:
            told = self._state and (self._state.revision, self._state.speed_set_point)
            if told != (block.revision, self._simulator.course.at(block.first_step).set_point):
                self._tell(state(self._simulator, block), RUNNING, timing)
        self._record(messages)
        self._outputs.publish_chunk(block, messages, self._start_ns)

    def _tell(self, found: State, status: int, timing: Timing | None = None, message: str = "") -> None:
        timing = timing or Timing(float("nan"), 0.0)
        self._state = replace(
            found,
            status=status,
            message=message,
            real_time_factor=timing.real_time_factor,
            lag=timing.lag,
            recording=self._recorder.path,
        )
        told = state_message(self._state, self._start_ns)
        self._record([told])
        self._outputs.publish([told])

    def _record(self, messages: list[Any]) -> None:
        try:
            self._recorder.write(messages)
        except RecordingError as reason:  # the stream is worth more than the bag
            self.get_logger().error(f"recording ends here: {reason}")
            self.lost = reason
            with suppress(RecordingError):
                self._recorder.stop()

    def _finish(self) -> None:
        """Tell what filters and detectors hold back, at the end of a run."""
        impacts = [impact_message(impact, self._start_ns) for impact in self._monitoring.finish()]
        self._record(impacts)
        self._outputs.publish(impacts)
        self._outputs.finish()

    def _on_end(self, failure: Exception | None) -> None:
        """In the stream's thread: the run is over by itself, or the simulation cannot go on."""
        self._finish()
        if failure is None:
            self._end(None)
            return
        self.get_logger().error(f"the simulation stopped: {failure!r}")
        if self._simulator is not None:
            self._tell(state(self._simulator), FAILED, message=str(failure))
        self._monitoring.fail(str(failure))
        with suppress(RecordingError):
            self._recorder.stop()
        if self._pace.duration > 0 or not isinstance(failure, WheelsetTrackError):
            self._end(failure)

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """All or nothing: one call is one revision."""
        with self._lock:
            try:
                changes = {item.name: item.value for item in parameters}
                scenario, pace = self.parameters.changed(changes)
                watching = self.parameters.watching(changes)
                if scenario != self._scenario and self._simulator is not None:
                    revision = self._simulator.apply(scenario)
                    self.get_logger().info(f"revision {revision.number} from step {revision.step}")
            except WheelsetTrackError as refusal:  # a value out of range, or a defect without a contact law
                return SetParametersResult(successful=False, reason=str(refusal))
            self._scenario = scenario
            self._outputs.decimation = self.parameters.decimation(changes)
            self._monitoring.change(watching, pace.real_time_factor)
            if pace != self._pace:
                self._pace = pace
                if self._stream is not None:
                    self._stream.set_pace(pace)
        return SetParametersResult(successful=True)
