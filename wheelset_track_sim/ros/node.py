"""The ROS 2 node: a managed (lifecycle) node around a run that streams in a thread of its own."""

from __future__ import annotations

import dataclasses
import threading
import traceback
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from pathlib import Path
from threading import Timer
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..bags.settings import RecordSettings
from ..errors import InputError, RecordingError, WheelsetTrackError
from ..live.fatigue_watch import FatigueWatch
from ..live.recorder import LONGEST_OF_FILE, Recorder, path_below
from ..live.revisions import Revisions
from ..monitoring.status import recording_status
from ..scenario import Scenario
from ..scenario.values import values_of
from ..simulation.changes import Applied, OvertakenError, Revision
from ..simulation.fleet import ModelPool
from ..simulation.models import compile_for_changes
from ..simulation.simulator import Simulator
from .answers import answer_always
from .clock import NodeClock
from .lost_answers import LostAnswers
from .monitoring import Monitoring
from .outputs import Outputs
from .parameters import Parameters
from .position import Frames, PositionTopics
from .run import NodeRun
from .services import Services
from .standard import StandardServices
from .turns import in_turns

NAME = "wheelset_track_sim"
MOST_STEPS = 10**8
"""Steps that are taken at a time at most: an hour of the run."""
ANSWER_TIME = 1.0
"""Time for the client to receive the answer before the node ends, s."""
TOLD = 0.05
"""Time between two reports of the steps that are done, s."""
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class Interrupted(WheelsetTrackError):  # noqa: N818  no error: it was told to
    """A signal ended the node while it built its models."""


class SimulationNode(LifecycleNodeMixin, Node):  # type: ignore[misc]
    """A wheelset on a track that publishes contact forces and axle stresses while it runs.

    Configuring builds or loads the models, activating streams, deactivating pauses (the bag stays open), cleaning up
    frees the models and closes the bag. Topics are in ``outputs``, ``monitoring`` and ``services``, which has the
    services too, parameters in ``parameters``, and what all of them change goes through ``revisions``.
    """

    def __init__(
        self, end: Callable[[Exception | None], None], name: str = NAME, models: ModelPool | None = None
    ) -> None:
        """``end`` is called when the node is through by itself; ``models`` are those of the nodes of one process.

        Raises InputError for parameters it cannot use.
        """
        self.changing = MutuallyExclusiveCallbackGroup()
        """Of all that changes the scenario: one change after the other, in the order in which they came."""
        Node.__init__(self, name)
        # Building models takes a while: the services of the lifecycle and of parameters must not queue behind it.
        LifecycleNodeMixin.__init__(self, callback_group=ReentrantCallbackGroup())
        self._end = end
        self._models = models or ModelPool()
        self._transition = threading.RLock()
        self._stepping = threading.Lock()
        self._interrupted = False
        self._overtaken = False  # by an event, while parameters are set
        self._accepted = ""  # what to know of parameters that were set
        self._refusal: WheelsetTrackError | None = None
        self.parameters = Parameters(self)
        self._pace = self.parameters.pace({})
        self._time = NodeClock(self, publish=self.parameters["publish_clock"])
        scenario = self.parameters.changed({}, self.parameters.file)
        self.revisions = Revisions(scenario, self.parameters.follow, self._stop_if_interrupted)
        self.run: NodeRun | None = None
        """From configuring to cleaning up."""
        self._configuring = False
        self._steps: int | None = None  # after which the run stands still again
        self._bag: Path | None = None  # to be opened at step 0
        self._earliest_ns = 0  # time stamp of the next run: stamps do not go back
        frames = Frames.of(self.get_fully_qualified_name(), self.parameters["frame_prefix"])
        odometry, tf = self.parameters["publish_odometry"], self.parameters["publish_tf"]
        position = PositionTopics(self, frames, odometry=odometry, tf=tf)
        self._frame = frames.track
        self._outputs = Outputs(self, self.parameters.decimation({}), frames.track, position)
        self.recorder = Recorder(self.get_fully_qualified_name(), self.get_logger().error)
        self._set_recorder(self.parameters.recording({}))
        lost = LostAnswers(self.get_logger())
        self._monitoring = Monitoring(
            self, self.parameters, lambda: [recording_status(self.recorder.figures), lost.status()]
        )
        Services(self)
        self._standard = StandardServices(self)
        answer_always(self)
        for service in self.services:
            lost.watch(service)
        self._turns = in_turns(self)
        self.add_on_set_parameters_callback(self._on_parameters)

    @property
    def lost(self) -> RecordingError | None:
        """What ended the last recording before its time."""
        return self.recorder.lost

    def autostart(self) -> None:
        """Configure and activate; a failure ends the node."""
        try:
            started = self.trigger_configure() == SUCCESS and self.trigger_activate() == SUCCESS
        except Exception as failure:  # noqa: BLE001  another has sent the node through its states meanwhile
            self._end(failure)
            return
        if not started:
            self._end(self._refusal or WheelsetTrackError("the node did not start: see its log"))

    def on_configure(self, previous: LifecycleState) -> TransitionCallbackReturn:
        """Build or load the models and settle."""
        self._configuring = True
        try:
            return self._guarded(self._configure, previous)
        finally:
            self._configuring = False

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

    def interrupt(self) -> None:
        """Break off what is being built, changed or waited for: the node is about to be closed."""
        self._interrupted = True
        self._time.wake()

    def close(self) -> None:
        """End the run from outside of all callbacks: stop, close the bag."""
        self.interrupt()
        for turns in self._turns:
            turns.close()
        with self._transition:  # models that are being built notice
            pass
        with suppress(Exception):  # a state without a way to shut down
            self.trigger_shutdown()
        self._release(None)

    def create_service(self, srv_type: Any, *arguments: Any, **options: Any) -> Any:
        """As that of every node; who sets parameters waits for changes at hand, who reads them does not."""
        if srv_type in (SetParameters, SetParametersAtomically):
            options["callback_group"] = self.changing
        return super().create_service(srv_type, *arguments, **options)

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """As that of every node; no other change comes between the check of the values and the values themselves."""
        with self.revisions.lock:
            if self.parameters.following:
                return super().set_parameters_atomically(parameter_list)
            self._overtaken = True
            while self._overtaken:  # again if an event of the run comes between the check and the change
                self.revisions.catch_up()
                self._accepted, self._overtaken = "", False
                result = super().set_parameters_atomically(parameter_list)
            if result.successful:
                result.reason = self._accepted
            else:
                self.get_logger().warning(f"parameters are rejected: {result.reason}")
            return result

    def tell_change(self, by: str, before: Scenario, revision: Revision) -> str:
        """Log a change that was accepted, by what means it came; what to know about it, empty if nothing changed.

        ``before`` is the scenario before it.
        """
        if self.revisions.scenario == before:
            self.get_logger().debug(f"{by}: nothing changes")  # a slider that stands still says so all the time
            return ""
        told = "in force when the run begins"
        if self.run is not None:
            told = f"revision {revision.number} from step {revision.step}"
        self.get_logger().info(f"{by}: {told}")
        return told if self.run is not None else ""

    def start_recording(self, name: str = "") -> tuple[Path, int]:
        """Record to a bag of a name, or of date and time; its path and first step. Raises InputError."""
        folder = self.parameters["record.directory"]
        path = path_below(folder, name) if name else self.recorder.path_now(folder)
        first_step = self.needed_run().start_recording(path)
        self.get_logger().info(f"recording to {path} from step {first_step}")
        return path, first_step

    def pause(self) -> str:
        """Deactivate; what to know about it. Raises InputError if there is nothing to pause."""
        return self._switch(self.trigger_deactivate, running=False)

    def resume(self) -> str:
        """Activate; what to know about it. Raises InputError if there is nothing to resume."""
        return self._switch(self.trigger_activate, running=True)

    def step(self, steps: int, told: Callable[[int], bool] = lambda done: True) -> tuple[int, int]:
        """Run a paused node for so many steps, as fast as possible; returns the first step and the next one.

        ``told`` is called now and then with the steps that are done; if it returns False, the node pauses at once.
        Raises InputError if there is no run, or it is not paused.
        """
        if not 1 <= steps <= MOST_STEPS:
            raise InputError(f"{steps} steps are out of range: give from 1 to {MOST_STEPS}")
        run = self.needed_run()
        first = run.next_step
        with self._stepping:
            if run.running:
                raise InputError("the node is running: pause it first")
            self._steps = steps
            try:
                self._switch(self.trigger_activate, running=True)
                while not run.stands_still(TOLD) and told(run.next_step - first):
                    pass
            finally:
                self._steps = None
                if run is self.run:
                    self._switch(self.trigger_deactivate, running=False)
                self._set_recorder(self.parameters.recording({}))
        return first, run.next_step

    def reset(self) -> str:
        """Begin a new run from step 0 with the scenario accepted last, in the state at hand; what to know about it.

        A bag that is being written ends with the old run; the new one goes into a bag beside it. Raises
        WheelsetTrackError if there is no run, or the new one cannot begin; one that cannot go on stands, inactive.
        """
        if not self._transition.acquire(blocking=False):
            raise InputError("the node is changing its state: reset it afterwards")
        running = self.run is not None and self.run.running
        try:
            self._renew()
            return f"a new run from step 0{f', recorded to {self.recorder.path}' if self.recorder.path else ''}"
        except WheelsetTrackError as refusal:
            self.get_logger().error(f"reset: {refusal}")
            if running and not self.needed_run().running:
                with suppress(Exception):  # of the state machine: another has begun a transition
                    self.trigger_deactivate()
                self._monitoring.fail(str(refusal))
            raise
        finally:
            self._transition.release()

    def _renew(self) -> None:
        """Replace the run by a new one, which continues if the old one was running."""
        before = self.needed_run()
        simulator = Simulator(self.revisions.scenario, self._stop_if_interrupted, before.simulator.models)
        simulator.settle()
        running, recording = before.running, self.recorder.path
        before.end()
        with suppress(RecordingError):  # the recorder keeps it
            self.recorder.stop().result()
        self._begin(simulator, self.recorder.beside() if recording else None)
        if running:
            self._go_on()
        else:
            self.needed_run().stand("reset, not active")

    def load(self, scenario: Scenario) -> None:
        """Clean up, and configure with another scenario; raises WheelsetTrackError if that fails."""
        if self.run is not None:
            self.unload()
        self.revisions.begin(scenario)
        self._make(self.trigger_configure)

    def unload(self) -> None:
        """Clean up, from any state that has a run; raises InputError if there is none."""
        if self.needed_run().running:
            self._make(self.trigger_deactivate)
        self._make(self.trigger_cleanup)

    def quit(self) -> None:
        """End the node when who asked for it has the answer."""
        Timer(ANSWER_TIME, self._end, [None]).start()

    @property
    def configuring(self) -> bool:
        """Whether models are being loaded or built."""
        return self._configuring

    def needed_run(self) -> NodeRun:
        """The run; raises InputError if there is none."""
        if self.run is None:
            raise InputError("there is no run: configure the node first")
        return self.run

    def _switch(self, trigger: Callable[[], TransitionCallbackReturn], *, running: bool) -> str:
        if self.needed_run().running == running:
            return "running already" if running else "paused already"
        self._make(trigger)
        return ""

    def _make(self, trigger: Callable[[], TransitionCallbackReturn]) -> None:
        """Make a transition; raises WheelsetTrackError if it cannot be made."""
        try:
            done = trigger() == SUCCESS
        except Exception:  # noqa: BLE001  of the state machine: another has begun a transition
            raise InputError("the node is changing its state: try again") from None
        if not done:
            raise self._refusal or InputError("the node did not change its state: see its log")

    def _guarded(self, step: Callable[[Any], None], previous: LifecycleState) -> TransitionCallbackReturn:
        """Run one transition: an expected error is logged in one line and fails it, any other with its traceback."""
        self._refusal = None
        with self._transition:
            try:
                step(previous)
            except Interrupted:
                return FAILURE
            except WheelsetTrackError as refusal:
                self._refusal = refusal
                self.get_logger().error(str(refusal))
                self._monitoring.fail(str(refusal))
                return FAILURE
            except Exception as failure:
                self.get_logger().fatal(traceback.format_exc())
                self._monitoring.fail(repr(failure))
                raise
        return SUCCESS

    def _configure(self, previous: LifecycleState) -> None:
        stages: set[str] = set()

        def progress(stage: str, fraction: float) -> None:
            self._stop_if_interrupted(stage, fraction)
            if stage not in stages:
                stages.add(stage)
                self.get_logger().info(stage)
            self._monitoring.building(stage, fraction)

        scenario = self.revisions.scenario
        simulator = Simulator(scenario, progress, self._models.models(scenario, progress))
        simulator.settle()
        bag = None
        if self.parameters["record.on_start"]:
            folder, name = self.parameters["record.directory"], self.parameters["record.name"]
            bag = path_below(folder, name, LONGEST_OF_FILE) if name else self.recorder.path_now(folder)
        try:
            made = simulator.scenario
            counted = self.parameters.fatigue() is not None
            self._outputs.create(made.output.stress_nodes, made.sensors, made.wayside, fatigue=counted)
            LifecycleNodeMixin.on_configure(self, previous)
            self._begin(simulator, bag)
        except Exception:
            self._release(None)
            raise
        self.needed_run().stand("configured, not active")

    def _begin(self, simulator: Simulator, bag: Path | None) -> None:
        """A run that is paused at step 0; ``bag`` is opened when it continues."""
        self.revisions.attach(simulator)
        compile_for_changes(simulator.scenario)
        self._monitoring.begin(simulator, self._pace.real_time_factor)
        outlets = self._outputs, self._monitoring, self.recorder
        impacts = self.parameters.watching({}).impact
        settings, log = self.parameters.fatigue(), self.get_logger()
        fatigue = FatigueWatch(simulator, settings, log.warning) if settings else None
        run = NodeRun(simulator, *outlets, self._time, log, self._on_end, impacts, self._on_event, self._frame, fatigue)
        run.messages.start_ns = self._now_ns()
        self.run, self._bag = run, bag

    def _activate(self, previous: LifecycleState) -> None:
        if self.run is None or self._interrupted:
            raise Interrupted
        self._wait_for_time()
        LifecycleNodeMixin.on_activate(self, previous)
        try:
            self._go_on()
        except Exception:
            LifecycleNodeMixin.on_deactivate(self, previous)
            raise

    def _wait_for_time(self) -> None:
        """With ``use_sim_time`` stamps and pace begin with the first message on ``/clock``."""
        self._time.warn_of_others()
        if self._time.now_ns() > 0:
            return
        told = "waiting for the time on /clock"
        self.get_logger().info(told)
        self._monitoring.pause(told)
        self._time.wait_for_time(lambda: self._interrupted)
        self._stop_if_interrupted("", 0.0)

    def _go_on(self) -> None:
        run = self.needed_run()
        if run.next_step == 0 and not self.recorder.path:
            run.messages.start_ns = self._now_ns()
            if self._bag is not None:
                self.recorder.take(self.recorder.open(self._bag, run.simulator, run.start_ns))
            self._bag = None
        simulator, path = run.simulator, self.recorder.path
        if self._steps is not None:  # by itself it would follow the clock
            self.recorder.patient = True
            run.go_on(dataclasses.replace(self._pace, real_time_factor=0.0), self._steps)
            return
        self.get_logger().info(
            f"streaming {simulator.scenario.name} from step {simulator.next_step} at {simulator.speed:g} m/s"
            + (f", recording to {path}" if path else "")
        )
        run.go_on(self._pace)

    def _deactivate(self, previous: LifecycleState) -> None:
        if self.run is not None:
            self.run.pause()
        LifecycleNodeMixin.on_deactivate(self, previous)

    def _release(self, previous: LifecycleState | None) -> None:
        run = self.run
        if run is not None:
            run.end()
            if run.next_step > 0:
                self._earliest_ns = run.end_ns
        self.run = None
        self.revisions.detach()
        self._outputs.destroy()
        path = self.recorder.stop().result()
        if path:
            self.get_logger().info(f"recorded {path}")
        self._monitoring.end()

    def _now_ns(self) -> int:
        """Time stamp of a run that begins now: the clock's, but after all stamps of the run before."""
        if self.run is not None:
            self._earliest_ns = max(self._earliest_ns, self.run.end_ns if self.run.next_step else 0)
        return max(self._earliest_ns, self._time.now_ns())

    def _stop_if_interrupted(self, stage: str, fraction: float) -> None:
        if self._interrupted:
            raise Interrupted("the node ends")

    def _on_end(self, failure: Exception | None) -> None:
        """In the stream's thread: the run is over by itself, or the simulation cannot go on."""
        if failure is None or self._pace.duration > 0 or not isinstance(failure, WheelsetTrackError):
            self._end(failure)

    def _on_event(self, applied: Applied) -> None:
        """In the stream's thread: an event has happened; do what it asks of the node, and show what it has changed."""
        event, revision, log = applied.event, applied.revision, self.get_logger()
        assert event is not None
        log.info(f"{event} ({', '.join(event.what)}): revision {revision.number} from step {revision.step}")
        try:
            if event.record == "start":
                self.start_recording()
            elif event.record == "stop":
                self.needed_run().end_recording().add_done_callback(partial(_tell, log, "recorded"))
            if event.snapshot:
                self.needed_run().begin_snapshot().add_done_callback(partial(_tell, log, "took the snapshot"))
        except WheelsetTrackError as refusal:
            log.warning(f"{event} is rejected: {refusal}")
        if self.executor is not None:
            self.executor.create_task(self.revisions.catch_up)

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """All or nothing: one call is one revision."""
        if self.parameters.following:
            return SetParametersResult(successful=True)
        changes = {item.name: item.value for item in parameters}
        try:
            self._check_clock(changes)
            pace, watching = self.parameters.pace(changes), self.parameters.watching(changes)
            recording = self.parameters.recording(changes)
            before = self.revisions.scenario
            revision = self.revisions.change(lambda scenario: self.parameters.changed(changes, scenario))
        except OvertakenError as reason:
            self._overtaken = True
            return SetParametersResult(successful=False, reason=str(reason))
        except WheelsetTrackError as refusal:  # a value out of range, or a defect without a contact law
            return SetParametersResult(successful=False, reason=str(refusal))
        if changes.keys() & values_of(before):
            self._accepted = self.tell_change("parameters", before, revision)
        if changes.get("use_sim_time", self._time.following) != self._time.following:
            self._earliest_ns = 0  # stamps of another time
        self._outputs.decimation = self.parameters.decimation(changes)
        self._monitoring.change(watching, pace.real_time_factor)
        if self.run is not None:
            self.run.messages.detector.settings = watching.impact
        if pace != self._pace:
            self._pace = pace
            if self.run is not None:
                self.run.set_pace(pace)
        self._set_recorder(recording)
        return SetParametersResult(successful=True)

    def _set_recorder(self, settings: RecordSettings) -> None:
        self.recorder.settings, self.recorder.patient = settings, self._pace.real_time_factor == 0

    def _check_clock(self, changes: Mapping[str, Any]) -> None:
        """Raises InputError for a change of the clock that the run at hand cannot follow."""
        following = changes.get("use_sim_time", self._time.following)
        self.parameters.check_clock(following)
        if following != self._time.following and self.run is not None and self.run.next_step > 0:
            raise InputError(
                "use_sim_time cannot change during a run, whose time stamps must continue: clean up the node first"
            )


def _tell(log: Any, what: str, done: Future[Any]) -> None:
    """Log what has been written in the meantime, or why it has not."""
    try:
        log.info(f"{what} {done.result()}")
    except WheelsetTrackError as refusal:
        log.warning(str(refusal))
