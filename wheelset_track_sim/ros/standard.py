"""The standard services of simulators, ``simulation_interfaces``, where that package is installed.

A world is a scenario, and the one entity in it is the wheelset. ``docs/reference/interface.md`` says what each answers.
"""

from __future__ import annotations

import math
import re
import traceback
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any, Protocol

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup

from ..errors import InputError, WheelsetTrackError
from ..inputs import shipped
from ..inputs.yaml12 import parse
from ..irregularities.listing import LONGEST, locate_files
from ..live.recorder import path_below
from ..live.revisions import Revisions
from ..scenario import Scenario, load_scenario, scenario_from
from ..scenario.events import plain_brought
from .conversions import header
from .parameters import Parameters
from .position import Motion
from .run import NodeRun
from .turns import REQUESTS

PACKAGE = "simulation_interfaces"
FEATURES = (
    "ENTITY_CATEGORIES",
    "ENTITY_STATE_GETTING",
    "ENTITY_INFO_GETTING",
    "SIMULATION_RESET",
    "SIMULATION_STATE_GETTING",
    "SIMULATION_STATE_SETTING",
    "SIMULATION_STATE_PAUSE",
    "STEP_SIMULATION_SINGLE",
    "STEP_SIMULATION_MULTIPLE",
    "STEP_SIMULATION_ACTION",
    "WORLD_LOADING",
    "WORLD_RESOURCE_STRING",
    "WORLD_UNLOADING",
    "WORLD_INFO_GETTING",
    "AVAILABLE_WORLDS",
)
"""What is supported; versions of the package that do not know one leave it out."""
UNSUPPORTED = (
    "DeleteEntity",
    "GetEntityBounds",
    "GetNamedPoseBounds",
    "GetNamedPoses",
    "GetSpawnables",
    "SetEntityInfo",
    "SetEntityState",
    "SpawnEntities",
    "SpawnEntity",
)
"""Services that answer so."""
LONGEST_FILTER = 200
"""Characters of a regular expression."""
Answer = tuple[int, str, dict[str, Any]]
"""Code of the standard, message, further fields of the response."""


class Simulating(Protocol):
    """A node that the services control."""

    revisions: Revisions
    parameters: Parameters
    run: NodeRun | None

    @property
    def configuring(self) -> bool:
        """Whether models are being loaded."""
        ...

    def pause(self) -> str:
        """Pause the run; raises WheelsetTrackError if that fails."""
        ...

    def resume(self) -> str:
        """Let the run go on; raises WheelsetTrackError if that fails."""
        ...

    def reset(self) -> str:
        """Begin a new run; raises WheelsetTrackError if that fails."""
        ...

    def step(self, steps: int, told: Callable[[int], bool] = ...) -> tuple[int, int]:
        """Take steps while paused; raises InputError if that cannot be."""
        ...

    def load(self, scenario: Scenario) -> None:
        """Configure with another scenario; raises WheelsetTrackError if that fails."""
        ...

    def unload(self) -> None:
        """Clean up; raises WheelsetTrackError if that fails."""
        ...

    def quit(self) -> None:
        """End the node."""
        ...

    def get_name(self) -> str:
        """Name in ROS."""
        ...

    def get_logger(self) -> Any:
        """Logger of ROS."""
        ...

    def create_service(self, srv_type: Any, *arguments: Any, **options: Any) -> Any:
        """Service of ROS."""
        ...


class StandardServices:
    """Servers of one node, below its name; none where ``simulation_interfaces`` is not installed."""

    def __init__(self, node: Simulating) -> None:
        """For ``node``, as long as it lives."""
        self._node = node
        self._held: NodeRun | None = None  # the run that was paused before its first step
        try:
            srv, self._msg = import_module(f"{PACKAGE}.srv"), import_module(f"{PACKAGE}.msg")
        except ModuleNotFoundError:
            return
        self._result, self._states = self._msg.Result, self._msg.SimulationState
        switching, stepping = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        asking = ReentrantCallbackGroup()
        for kind, answer, group in (
            ("GetSimulatorFeatures", self._features, asking),
            ("GetSimulationState", self._get_state, asking),
            ("SetSimulationState", self._set_state, switching),
            ("ResetSimulation", self._reset, switching),
            ("StepSimulation", self._step, stepping),
            ("LoadWorld", self._load_world, switching),
            ("UnloadWorld", self._unload_world, switching),
            ("GetCurrentWorld", self._current_world, asking),
            ("GetAvailableWorlds", self._available_worlds, asking),
            ("GetEntities", self._entities, asking),
            ("GetEntitiesStates", self._entities_states, asking),
            ("GetEntityInfo", self._entity_info, asking),
            ("GetEntityState", self._entity_state, asking),
            *((kind, self._unsupported, asking) for kind in UNSUPPORTED),
        ):
            if hasattr(srv, kind):  # versions differ
                name = re.sub("(?<=[a-z])(?=[A-Z])", "_", kind).lower()
                answered = partial(self._answered, name, answer)
                node.create_service(
                    getattr(srv, kind), f"~/{name}", answered, qos_profile=REQUESTS, callback_group=group
                )
        self._serve_action()

    def _serve_action(self) -> None:
        from rclpy.action import ActionServer, CancelResponse  # costs time where it is not needed

        action = import_module(f"{PACKAGE}.action").SimulateSteps
        self._action = ActionServer(
            self._node,
            action,
            "~/simulate_steps",
            partial(self._simulate_steps, action),
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def _answered(self, name: str, answer: Callable[[Any, Any], Answer], request: Any, response: Any) -> Any:
        """``response`` with an answer, whatever happens."""
        code, message, fields = self._safe(name, partial(answer, request, response))
        if hasattr(response, "result"):
            response.result.result, response.result.error_message = code, message
        for field, value in fields.items():
            setattr(response, field, value)
        return response

    def _safe(self, name: str, answer: Callable[[], Answer]) -> Answer:
        log = self._node.get_logger()
        try:
            code, message, fields = answer()
        except WheelsetTrackError as refusal:
            code, message, fields = self._result.RESULT_OPERATION_FAILED, str(refusal), {}
        except Exception as failure:  # noqa: BLE001  the executor must live, and the client must not wait
            log.fatal(traceback.format_exc())
            code, message, fields = self._result.RESULT_OPERATION_FAILED, f"it failed, see the log: {failure!r}", {}
        if code != self._result.RESULT_OK:
            log.warning(f"{name} is rejected: {message}")
        return code, message, fields

    def _ok(self, **fields: Any) -> Answer:
        return self._result.RESULT_OK, "", fields

    def _unsupported(self, request: Any, response: Any, what: str = "this service") -> Answer:
        return self._result.RESULT_FEATURE_UNSUPPORTED, f"{what} is not supported: see get_simulator_features", {}

    def _features(self, request: Any, response: Any) -> Answer:
        known = self._msg.SimulatorFeatures
        found = [getattr(known, name) for name in FEATURES if hasattr(known, name)]
        info = "wheelset_track_sim: a world is a scenario, the entity is the wheelset; see docs/reference/interface.md"
        return self._ok(features=known(features=found, custom_info=info))

    @property
    def _state(self) -> int:
        run, states = self._node.run, self._states
        if run is None:
            return int(states.STATE_LOADING_WORLD if self._node.configuring else states.STATE_NO_WORLD)
        if run.running:
            return int(states.STATE_PLAYING)
        return int(states.STATE_PAUSED if run.next_step > 0 or run is self._held else states.STATE_STOPPED)

    def _get_state(self, request: Any, response: Any) -> Answer:
        return self._ok(state=self._states(state=self._state))

    def _set_state(self, request: Any, response: Any) -> Answer:
        states, node = self._states, self._node
        wanted, state = request.state.state, self._state
        if wanted == states.STATE_QUITTING:
            node.quit()
            return self._ok()
        if wanted not in (states.STATE_STOPPED, states.STATE_PLAYING, states.STATE_PAUSED):
            return self._result.RESULT_OPERATION_FAILED, f"state {wanted} cannot be set: load or unload a world", {}
        if state in (states.STATE_NO_WORLD, states.STATE_LOADING_WORLD):
            return self._result.RESULT_INCORRECT_STATE, "there is no run: load a world first", {}
        if wanted == state:
            return response.ALREADY_IN_TARGET_STATE, "it is in this state already", {}
        try:
            if wanted == states.STATE_PLAYING:
                node.resume()
            else:
                node.pause()
        except WheelsetTrackError as refusal:
            return response.STATE_TRANSITION_ERROR, str(refusal), {}
        if wanted == states.STATE_STOPPED:
            node.reset()
        self._held = node.run if wanted == states.STATE_PAUSED else None
        return self._ok()

    def _reset(self, request: Any, response: Any) -> Answer:
        both = request.SCOPE_TIME | request.SCOPE_STATE
        if request.scope != request.SCOPE_DEFAULT and request.scope & both != both:
            return self._unsupported(request, response, "a reset of time alone or of the state alone")
        self._node.reset()
        return self._ok()

    def _step(self, request: Any, response: Any) -> Answer:
        first, following = self._node.step(int(request.steps))
        return self._stepped(int(request.steps), following - first)

    def _stepped(self, wanted: int, done: int) -> Answer:
        if done < wanted:
            return self._result.RESULT_OPERATION_FAILED, f"{done} of {wanted} steps were taken, then it was paused", {}
        return self._ok()

    def _simulate_steps(self, action: Any, goal: Any) -> Any:
        """Execute a goal of the action, with feedback while it is under way."""
        wanted = int(goal.request.steps)

        def told(done: int) -> bool:
            goal.publish_feedback(action.Feedback(completed_steps=done, remaining_steps=max(0, wanted - done)))
            return not goal.is_cancel_requested

        def stepped() -> Answer:
            first, following = self._node.step(wanted, told)
            told(following - first)
            return self._stepped(wanted, following - first)

        code, message, _ = self._safe("simulate_steps", stepped)
        if goal.is_cancel_requested:
            goal.canceled()
        elif code == self._result.RESULT_OK:
            goal.succeed()
        else:
            goal.abort()
        return action.Result(result=self._result(result=code, error_message=message))

    def _load_world(self, request: Any, response: Any) -> Answer:
        resource = getattr(request, "world_resource", request)  # versions differ
        if not (resource.uri or resource.resource_string):
            return response.NO_RESOURCE, "uri and resource_string are empty: give one of them", {}
        if resource.uri and resource.uri not in shipped.names("scenarios"):
            known = ", ".join(shipped.names("scenarios"))
            return self._result.RESULT_NOT_FOUND, f"uri = {resource.uri!r} is not a shipped scenario: give {known}", {}
        try:
            scenario = load_scenario(resource.uri) if resource.uri else self._scenario(resource.resource_string)
        except InputError as refusal:
            return response.RESOURCE_PARSE_ERROR, str(refusal), {}
        self._held = None
        self._node.load(scenario)
        return self._ok(world=self._world(scenario))

    def _scenario(self, text: str) -> Scenario:
        """Scenario of a text that comes over the network: bounded, and files below a folder."""
        size = len(text.encode(errors="surrogatepass"))
        if size > LONGEST:
            raise InputError(f"resource_string has {size} bytes: give at most {LONGEST}")
        data = parse(text, "resource_string", trusted=False)
        if not isinstance(data, dict):
            raise InputError("resource_string is not a mapping of scenario keys: see docs/reference/scenarios.md")

        def located(name: str) -> str:
            return str(path_below(self._node.parameters["profiles.directory"], name))

        irregularities, events = data.get("irregularities"), data.get("events")
        locate_files(irregularities if isinstance(irregularities, list) else [], located)
        for event in events if isinstance(events, list) else ():
            locate_files(plain_brought(event), located)
        return scenario_from(data)

    def _unload_world(self, request: Any, response: Any) -> Answer:
        if self._node.run is None:
            return response.NO_WORLD_LOADED, "there is no run", {}
        self._node.unload()
        return self._ok()

    def _current_world(self, request: Any, response: Any) -> Answer:
        if self._node.run is None:
            return response.NO_WORLD_LOADED, "there is no run", {}
        return self._ok(world=self._world(self._node.run.simulator.in_force))

    def _available_worlds(self, request: Any, response: Any) -> Answer:
        if request.filter.tags:
            return self._unsupported(request, response, "filter.tags")
        if request.additional_sources and not request.continue_on_error:
            return self._unsupported(request, response, "additional_sources")
        found = []
        for name in shipped.names("scenarios"):
            world = self._msg.WorldResource(name=name, description=shipped.description("scenarios", name))
            world.world_resource.uri = name
            found.append(world)
        return self._ok(worlds=found)

    def _world(self, scenario: Scenario) -> Any:
        world = self._msg.WorldResource(name=scenario.name)
        world.world_resource.resource_string = scenario.to_yaml()
        return world

    def _entities(self, request: Any, response: Any) -> Answer:
        filters, names = request.filters, [] if self._node.run is None else [self._node.get_name()]
        if filters.tags.tags:
            return self._unsupported(request, response, "filters.tags")
        if filters.bounds.type != filters.bounds.TYPE_EMPTY:
            return self._unsupported(request, response, "filters.bounds")
        wanted = [each.category for each in filters.categories]
        if wanted and self._msg.EntityCategory.CATEGORY_DYNAMIC_OBJECT not in wanted:
            names = []
        if len(filters.filter) > LONGEST_FILTER:
            raise InputError(f"filters.filter has {len(filters.filter)} characters: give at most {LONGEST_FILTER}")
        try:
            names = [name for name in names if re.fullmatch(filters.filter or ".*", name)]
        except re.error as reason:
            raise InputError(f"filters.filter = {filters.filter!r} is no regular expression: {reason}") from None
        return self._ok(entities=names)

    def _entities_states(self, request: Any, response: Any) -> Answer:
        code, message, fields = self._entities(request, response)
        fields["states"] = [self._moving() for _ in fields.get("entities", ())]
        return code, message, fields

    def _entity_info(self, request: Any, response: Any) -> Answer:
        run = self._node.run
        if run is None or request.entity != self._node.get_name():
            return self._nobody(request.entity)
        info = self._msg.EntityInfo(description=f"wheelset {run.simulator.in_force.wheelset.name}")
        info.category.category = self._msg.EntityCategory.CATEGORY_DYNAMIC_OBJECT
        return self._ok(info=info)

    def _entity_state(self, request: Any, response: Any) -> Answer:
        if self._node.run is None or request.entity != self._node.get_name():
            return self._nobody(request.entity)
        return self._ok(state=self._moving())

    def _nobody(self, entity: str) -> Answer:
        there = "there is none" if self._node.run is None else f"there is {self._node.get_name()}"
        return self._result.RESULT_NOT_FOUND, f"entity = {entity!r} is not here: {there}", {}

    def _moving(self) -> Any:
        """State of the wheelset at the end of what has been delivered, in the frame of the track."""
        run = self._node.run
        assert run is not None
        motion = Motion.at(run.simulator, run.next_step)
        state = self._msg.EntityState(header=header(motion.time, run.start_ns, run.frame))
        state.pose.position.x, state.pose.position.y, state.pose.position.z = motion.x, motion.y, motion.z
        half, radius = motion.angle / 2, motion.radius
        state.pose.orientation.y, state.pose.orientation.w = math.sin(half), math.cos(half)
        state.twist.linear.x, state.twist.angular.y = motion.speed, motion.speed / radius
        state.acceleration.linear.x, state.acceleration.angular.y = motion.acceleration, motion.acceleration / radius
        return state
