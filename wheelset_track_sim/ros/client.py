"""A running node seen from outside: its parameters, services and topics, where there is no ``ros2``."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from importlib import import_module
from typing import Any

import rclpy
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import GetParameters, GetParameterTypes, ListParameters, SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from ..errors import InputError, WheelsetTrackError
from ..inputs.schema import unknown
from ..scenario.values import SCENARIO_NUMBERS, SIZE_C, quantity_named
from .hosting import refusing

ASKED_AGAIN = 1.0
"""Time after which the node is asked again whether it knows this client, s: the middleware loses the first answers."""
LOOKED_AGAIN = 0.01
"""Time after which the graph is looked at again for the node, s."""
FOUND = 10.0
"""Longest time in which a node that is there answers a client that it did not know, s."""
SETTLED = 2.0
"""Time in which the topics of a node that answers are known, s."""
DEPTH = 50
"""Messages of a topic that wait until they are taken."""
SEQUENCE = re.compile(r"(?:sequence<([\w/]+)(?:, \d+)?>|([\w/]+)\[\d*\])")
DAMAGE = re.compile(rf"wheel_[12]\.damage\.({'|'.join(SIZE_C)})")


class RemoteNode:
    """One node of the ROS graph by its name; every wait ends after ``patience`` s with WheelsetTrackError."""

    def __init__(self, node: Any, executor: Any, name: str, patience: float) -> None:
        self.name = name if name.startswith("/") else f"/{name}"
        self._node, self._executor, self._patience = node, executor, patience

    def parameters(self, names: Sequence[str] = ()) -> dict[str, Any]:
        """Values of parameters by name, of all if none is named; raises InputError for a name that is not one."""
        known = sorted(self._ask(ListParameters, "list_parameters", ListParameters.Request()).result.names)
        self._require(names, known)
        wanted = [*names] or known
        found = self._ask(GetParameters, "get_parameters", GetParameters.Request(names=wanted))
        return {name: parameter_value_to_python(value) for name, value in zip(wanted, found.values, strict=True)}

    def set_parameters(self, values: Mapping[str, Any]) -> str:
        """Set all parameters or none; returns what the node says. Raises InputError with its reason if it refuses."""
        known = sorted(self._ask(ListParameters, "list_parameters", ListParameters.Request()).result.names)
        self._require([*values], known)
        types = self._ask(GetParameterTypes, "get_parameter_types", GetParameterTypes.Request(names=[*values])).types
        request = SetParametersAtomically.Request()
        for (name, value), kind in zip(values.items(), types, strict=True):
            given = _number(name, value) if kind == ParameterType.PARAMETER_DOUBLE else value
            request.parameters.append(Parameter(name, value=given).to_parameter_msg())
        result = self._ask(SetParametersAtomically, "set_parameters_atomically", request).result
        if not result.successful:
            raise InputError(result.reason)
        return str(result.reason)

    def call(self, service: str, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Answer of a service in plain values; raises InputError for a service or a field that is not known."""
        path = self._path(service)
        kind = self._kind(self._node.get_service_names_and_types, path, "service")
        answer: dict[str, Any] = plain(self._ask(kind, path, filled(kind.Request(), fields, service)))
        return answer

    def messages(self, topic: str) -> Iterator[dict[str, Any]]:
        """Messages of a topic in plain values, as they come; waits for the first as long as it takes."""
        path = self._path(topic)
        kind = self._kind(self._node.get_topic_names_and_types, path, "topic")
        offered = [each.qos_profile for each in self._node.get_publishers_info_by_topic(path)]
        latched = bool(offered) and all(each.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in offered)
        lossy = any(each.reliability == ReliabilityPolicy.BEST_EFFORT for each in offered)
        quality = QoSProfile(
            depth=DEPTH,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
            reliability=ReliabilityPolicy.BEST_EFFORT if lossy else ReliabilityPolicy.RELIABLE,
        )
        waiting: list[Any] = []
        self._node.create_subscription(kind, path, waiting.append, quality)
        while True:
            self._executor.spin_once(timeout_sec=ASKED_AGAIN)
            while waiting:
                yield plain(waiting.pop(0))

    def _path(self, name: str) -> str:
        return name if name.startswith("/") else f"{self.name}/{name.removeprefix('~/')}"

    def _kind(self, listed: Callable[[], Sequence[tuple[str, Sequence[str]]]], path: str, what: str) -> Any:
        """Class of a service or topic; raises InputError if it is not there, or its package is not."""
        self._meet()
        limit = time.monotonic() + SETTLED
        while path not in (known := dict(listed())):
            if time.monotonic() >= limit:
                near = sorted(name for name in known if name.startswith(f"{self.name}/"))
                raise InputError(unknown(f"{what} of {self.name}", path, path, near))
            self._executor.spin_once(timeout_sec=0.1)
        return _interface(known[path][0])

    def _require(self, names: Sequence[str], known: Sequence[str]) -> None:
        for name in names:
            if name not in known:
                raise InputError(unknown(f"parameter of {self.name}", repr(name), name, known))

    def _ask(self, kind: Any, service: str, request: Any) -> Any:
        """Answer of a service, asked once the node knows this client."""
        client = self._node.create_client(kind, self._path(service))
        self._meet()
        future = client.call_async(request)
        self._executor.spin_until_future_complete(future, self._patience)
        if not future.done():
            raise WheelsetTrackError(
                f"{self._path(service)} does not answer within {self._patience:g} s: give a longer --timeout"
            )
        return future.result()

    def _meet(self) -> None:
        """Wait until the node answers a client that is younger than all others: it then knows them, too."""
        newest = self._node.create_client(GetParameters, f"{self.name}/get_parameters")
        patience = min(FOUND, self._patience)
        limit = time.monotonic() + patience
        try:
            while time.monotonic() < limit:
                if not newest.service_is_ready():  # what is sent now is lost
                    self._executor.spin_once(timeout_sec=LOOKED_AGAIN)
                    continue
                future = newest.call_async(GetParameters.Request())
                self._executor.spin_until_future_complete(future, ASKED_AGAIN)
                if future.done():
                    return
                newest.remove_pending_request(future)
        finally:
            self._node.destroy_client(newest)
        raise WheelsetTrackError(
            f"no node {self.name} answers within {patience:g} s in ROS_DOMAIN_ID "
            f"{os.environ.get('ROS_DOMAIN_ID', '0')}: start it, or give its name with --node"
        )


@contextmanager
def connected(name: str, patience: float) -> Iterator[RemoteNode]:
    """Take part in the ROS graph as a client of a node."""
    context = rclpy.Context()
    with ExitStack() as stack, refusing():
        rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        stack.callback(context.try_shutdown)
        own = f"wheelset_track_sim_client_{os.getpid()}"
        node = rclpy.create_node(own, context=context, enable_rosout=False, start_parameter_services=False)
        stack.callback(node.destroy_node)
        executor = SingleThreadedExecutor(context=context)
        stack.callback(executor.shutdown)
        executor.add_node(node)
        yield RemoteNode(node, executor, name, patience)


def plain(message: Any) -> Any:
    """Plain values of a message, with the names of its fields."""
    if hasattr(message, "get_fields_and_field_types"):
        return {name: plain(getattr(message, name)) for name in message.get_fields_and_field_types()}
    if isinstance(message, bytes):
        return list(message)
    if isinstance(message, str) or not hasattr(message, "__iter__"):
        return message
    return message.tolist() if hasattr(message, "tolist") else [plain(each) for each in message]


def filled(message: Any, fields: Any, where: str) -> Any:
    """A message with its fields set from plain values; raises InputError, which begins with ``where``."""
    if not isinstance(fields, Mapping):
        raise InputError(f"{where} = {fields!r} is not a mapping of fields: give {', '.join(_types(message))}")
    for name, value in fields.items():
        types = _types(message)
        if name not in types:
            raise InputError(unknown("field", f"{where}.{name}", str(name), [*types]))
        try:
            setattr(message, name, _field(getattr(message, name), types[name], value, f"{where}.{name}"))
        except (AssertionError, TypeError, ValueError, OverflowError):
            raise InputError(f"{where}.{name} = {value!r} is not of type {types[name]}: give one") from None
    return message


def _field(there: Any, kind: str, value: Any, where: str) -> Any:
    """A plain value as a field of the given type, in which ``there`` is now."""
    if hasattr(there, "get_fields_and_field_types"):
        return filled(there, value, where)
    found = SEQUENCE.fullmatch(kind)
    element = (found[1] or found[2]) if found else ""
    if found and "/" in element and isinstance(value, Sequence):
        make = _interface(element)
        return [filled(make(), each, f"{where}.{index}") for index, each in enumerate(value)]
    floats = kind in ("float", "double") or (found is not None and element in ("float", "double"))
    if floats and isinstance(value, list):
        return [float(each) for each in value]
    return float(value) if floats and isinstance(value, int) and not isinstance(value, bool) else value


def _types(message: Any) -> dict[str, str]:
    types: dict[str, str] = message.get_fields_and_field_types()
    return types


def _interface(name: str) -> Any:
    """Class of ``package/msg/Name``, or ``package/Name`` of a message."""
    package, *folder, last = name.split("/")
    try:
        return getattr(import_module(f"{package}.{folder[0] if folder else 'msg'}"), last)
    except ModuleNotFoundError:
        raise InputError(f"the package {package} of the type {name} is not installed here: install it") from None


def _number(name: str, value: Any) -> Any:
    """Value of a parameter that is a number: in SI if it has a unit."""
    if name in SCENARIO_NUMBERS or DAMAGE.fullmatch(name):
        value = quantity_named(name).number(name, value)
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value
