"""Services of the node, and the topics that it listens to, all relative to its name."""

from __future__ import annotations

import dataclasses
import math
import traceback
from array import array
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger
from wheelset_track_msgs.msg import TreadDamageArray
from wheelset_track_msgs.srv import (
    GetContactPressure,
    GetSpectrum,
    ScheduleEvents,
    SetIrregularities,
    SetSpeed,
    SetTreadDamage,
    StartRecording,
    Step,
)

from ..errors import InputError, WheelsetTrackError
from ..live.fatigue_watch import FatigueWatch
from ..live.recorder import Recorder
from ..live.revisions import Revisions
from ..scenario import Scenario
from ..simulation.changes import Revision
from ..simulation.speed import NEARLY
from .answers import Answer, served
from .conversions import header
from .parameters import Parameters
from .run import NodeRun
from .turns import REQUESTS

FARTHEST = 1e5
"""Distance of a step at most, m."""
LEDGER = "fatigue.ledger"
"""File in the folder of recordings that holds fatigue if no other one is named."""
COMMANDS = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Of set points: where several wait, the latest counts."""


class Controlled(Protocol):
    """A node that the services control: its run, its changes, its recorder, and the interface of ROS."""

    changing: Any
    """Callback group of changes."""
    revisions: Revisions
    parameters: Parameters
    recorder: Recorder

    def needed_run(self) -> NodeRun:
        """The run; raises InputError if there is none."""
        ...

    def tell_change(self, by: str, before: Scenario, revision: Revision) -> str:
        """Log a change that was accepted."""
        ...

    def start_recording(self, name: str) -> tuple[Path, int]:
        """Record to a bag of a name; its path and first step. Raises InputError."""
        ...

    def pause(self) -> str:
        """Deactivate the node; raises InputError if there is nothing to pause."""
        ...

    def resume(self) -> str:
        """Activate the node; raises InputError if there is nothing to resume."""
        ...

    def step(self, steps: int) -> tuple[int, int]:
        """Run the paused node for so many steps; the first one and the next one. Raises InputError if it runs."""
        ...

    def reset(self) -> str:
        """Begin a new run from step 0; raises WheelsetTrackError if that fails."""
        ...

    def get_logger(self) -> Any:
        """Logger of ROS."""
        ...

    def create_service(self, srv_type: Any, *arguments: Any, **options: Any) -> Any:
        """Service of ROS."""
        ...

    def create_subscription(self, *arguments: Any, **options: Any) -> Any:
        """Subscription of ROS."""
        ...


class Services:
    """Servers and subscriptions of one node; each answers, whatever happens.

    Changes have a callback group, recordings and transitions have one, and so have steps and the contact pressure: none
    waits for another, and within each requests are answered in the order of arrival (``turns``). Of each command topic
    the newest message counts.
    """

    def __init__(self, node: Controlled) -> None:
        """For ``node``, as long as it lives."""
        self._node, log = node, node.get_logger()
        switching, asking, commanding, stepping = (MutuallyExclusiveCallbackGroup() for _ in range(4))
        for kind, name, answer, group in (
            (SetTreadDamage, "set_tread_damage", self._set_tread_damage, node.changing),
            (SetIrregularities, "set_irregularities", self._set_irregularities, node.changing),
            (SetSpeed, "set_speed", self._set_speed, node.changing),
            (ScheduleEvents, "schedule_events", self._schedule_events, node.changing),
            (StartRecording, "start_recording", self._start_recording, switching),
            (Trigger, "stop_recording", self._stop_recording, switching),
            (Trigger, "split_recording", self._split_recording, switching),
            (Trigger, "take_snapshot", self._take_snapshot, switching),
            (Trigger, "pause", lambda _: {"message": node.pause()}, switching),
            (Trigger, "resume", lambda _: {"message": node.resume()}, switching),
            (Trigger, "reset", lambda _: {"message": node.reset()}, switching),
            (Step, "step", self._step, stepping),
            (GetSpectrum, "get_spectrum", self._get_spectrum, asking),
            (Trigger, "save_fatigue", self._save_fatigue, asking),
            (GetContactPressure, "get_contact_pressure", self._get_contact_pressure, asking),
        ):
            answered = partial(served, log, name, answer)
            node.create_service(kind, f"~/{name}", answered, qos_profile=REQUESTS, callback_group=group)
        for message, name, take in (
            (Float64, "speed", lambda message: node.revisions.speed(message.data)),
            (Float64, "torque", lambda message: node.revisions.torque(message.data)),
            (TreadDamageArray, "tread_damage", lambda message: node.revisions.damage(message.damage)),
            (String, "irregularities", lambda message: self._irregularities(message.data)),
        ):
            topic = f"~/cmd/{name}"
            node.create_subscription(
                message, topic, partial(self._taken, topic, take), COMMANDS, callback_group=commanding
            )

    def _taken(self, topic: str, take: Callable[[Any], Revision], message: Any) -> None:
        try:
            answer = self._changed(topic, lambda: take(message))
        except Exception:  # noqa: BLE001  the executor must live
            self._node.get_logger().fatal(traceback.format_exc())
            return
        if not answer.get("success", True):
            self._node.get_logger().warning(f"{topic} is rejected: {answer['message']}")

    def _set_tread_damage(self, request: Any) -> Answer:
        return self._changed("set_tread_damage", lambda: self._node.revisions.damage(request.damage))

    def _set_irregularities(self, request: Any) -> Answer:
        return self._changed("set_irregularities", lambda: self._irregularities(request.irregularities))

    def _irregularities(self, text: str) -> Revision:
        return self._node.revisions.irregularities(text, self._node.parameters["profiles.directory"])

    def _set_speed(self, request: Any) -> Answer:
        return self._changed("set_speed", lambda: self._node.revisions.speed(request.speed, request.acceleration))

    def _schedule_events(self, request: Any) -> Answer:
        node = self._node
        folder = node.parameters["profiles.directory"]
        return self._changed(
            "schedule_events", lambda: node.revisions.schedule(request.events, folder, replace=request.replace)
        )

    def _changed(self, by: str, change: Callable[[], Revision]) -> Answer:
        """Revision and step of a change, which is logged; if it is rejected, those of the newest one with the reason.

        ``by`` is the topic or service through which it comes.
        """
        before = self._node.revisions.scenario
        try:
            revision, answer = change(), {}
            self._node.tell_change(by, before, revision)
        except WheelsetTrackError as refusal:
            revision, answer = self._node.revisions.newest, {"success": False, "message": str(refusal)}
        return {**answer, "revision": revision.number, "step": revision.step}

    def _start_recording(self, request: Any) -> Answer:
        node = self._node
        node.needed_run()
        try:
            path, first_step = node.start_recording(request.name)
        except InputError as refusal:
            return {"success": False, "message": str(refusal), "path": node.recorder.path}
        return {"path": str(path), "first_step": first_step}

    def _stop_recording(self, request: Any) -> Answer:
        path = self._node.needed_run().stop_recording()
        if not path:
            raise InputError("nothing is being recorded: start a recording first")
        self._node.get_logger().info(f"recorded {path}")
        return {"message": path}

    def _split_recording(self, request: Any) -> Answer:
        return {"message": str(self._node.needed_run().split_recording())}

    def _take_snapshot(self, request: Any) -> Answer:
        path = self._node.needed_run().take_snapshot()
        self._node.get_logger().info(f"took the snapshot {path}")
        return {"message": str(path)}

    def _step(self, request: Any) -> Answer:
        steps = self._steps_of(request)
        first, following = self._node.step(steps)
        done = following - first
        missing = "" if done >= steps else f"{done} of {steps} steps were taken: the run ended, or was paused"
        return {"success": not missing, "message": missing, "first_step": first, "next_step": following}

    def _steps_of(self, request: Any) -> int:
        """Steps that are asked for."""
        given = [name for name in ("steps", "chunks", "distance") if getattr(request, name)]
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} are given: give one of steps, chunks and distance")
        simulator = self._node.needed_run().simulator
        if request.steps:
            return int(request.steps)
        if request.distance:
            if not 0 < request.distance <= FARTHEST:
                raise InputError(
                    f"distance = {request.distance:g} m is out of range: give above 0, up to {FARTHEST:g} m"
                )
            return math.ceil(float(request.distance) / simulator.in_force.step_length - NEARLY)
        chunk = dataclasses.replace(self._node.parameters.pace({}), duration=0.0)
        chunks: int = max(1, request.chunks)
        return chunks * chunk.steps(simulator.time, simulator.step_period)

    def _fatigue(self) -> tuple[NodeRun, FatigueWatch]:
        """The run with its count of fatigue; raises InputError if there is none."""
        run = self._node.needed_run()
        if run.messages.fatigue is None:
            raise InputError("fatigue is not counted: start the node with fatigue.curve, such as assumed_body")
        return run, run.messages.fatigue

    def _get_spectrum(self, request: Any) -> Answer:
        run, watch = self._fatigue()
        found = watch.spectrum(request.node, None if request.worst else request.angle)
        spectrum = found.spectrum
        rows, columns = spectrum.half_cycles.shape[1:]
        return {
            "header": header(found.time, run.start_ns, run.frame),
            "next_step": found.next_step,
            "distance": found.distance,
            "angle": found.angle,
            "damage": array("d", spectrum.damage[0].tobytes()),
            "rows": rows,
            "columns": columns,
            "range_width": float(spectrum.ranges[1]),
            "mean_start": float(spectrum.means[0]),
            "mean_width": float(spectrum.means[1] - spectrum.means[0]),
            "half_cycles": array("Q", spectrum.half_cycles[0].astype("u8").tobytes()),
            "level_start": float(spectrum.levels[0]),
            "level_width": float(spectrum.levels[1] - spectrum.levels[0]),
            "crossings": array("Q", spectrum.crossings[0].astype("u8").tobytes()),
        }

    def _save_fatigue(self, request: Any) -> Answer:
        run, watch = self._fatigue()
        path = watch.settings.ledger or Path(self._node.parameters["record.directory"]).expanduser() / LEDGER
        if watch.settings.ledger is None:
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as reason:
                raise InputError(f"{path} cannot be written ({reason.strerror}): set fatigue.ledger") from None
        watch.save(path, run.start_ns)
        return {"message": str(path)}

    def _get_contact_pressure(self, request: Any) -> Answer:
        run = self._node.needed_run()
        if request.wheel not in (GetContactPressure.Request.WHEEL_1, GetContactPressure.Request.WHEEL_2):
            raise InputError(f"wheel = {request.wheel} is not a wheel: give 1 (far from the gearbox) or 2")
        kept = {
            GetContactPressure.Request.LATEST: run.contacts.latest,
            GetContactPressure.Request.WORST: run.contacts.worst,
        }
        if request.at not in kept:
            raise InputError(f"at = {request.at} is not known: give 0 (the latest step) or 1 (the largest force)")
        if not kept[request.at]:
            raise InputError("there is no step yet: activate the node first")
        instant = kept[request.at][request.wheel - 1]
        patch = instant.contact.solve()
        if patch.flag:
            self._node.get_logger().warning(f"wheel_{request.wheel} at step {instant.contact.step}: {patch.flag}")
        rows, columns = patch.pressure.shape
        return {
            "header": header(instant.time, run.start_ns, run.frame),
            "step": instant.contact.step,
            **{name: getattr(instant, name) for name in ("time", "speed", "position", "revision", "angle")},
            "approach": patch.approach,
            "force": patch.force,
            "rows": rows,
            "columns": columns,
            "dx": float(patch.x[1] - patch.x[0]),
            "dy": float(patch.y[1] - patch.y[0]),
            "x0": float(patch.x[0]),
            "y0": float(patch.y[0]),
            "pressure": array("d", patch.pressure.tobytes()),
        }
