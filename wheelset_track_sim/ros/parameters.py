"""Parameters of the node: declared once from the package's own quantities, mapped to a scenario and a pace."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..errors import InputError
from ..irregularities import Breakout
from ..monitoring.limits import Limits
from ..scenario import Scenario, load_scenario
from ..schema import Quantity, quantity_of
from ..simulation.decimation import FACTOR
from ..simulation.impacts import ImpactSettings
from ..simulation.pacing import Pace
from ..values import SCENARIO_NUMBERS, Values, values_of, with_values

START_UP = {
    "scenario": ("damage_wheel_1", "Name of a shipped scenario, or path of a scenario file"),
    "autostart": (True, "Configure and activate without being told"),
    "record.directory": ("recordings", "Folder in which bags are written"),
    "record.name": ("", "Name of the bag in record.directory; empty: made from date and time"),
    "record.on_start": (False, "Record from the start of the run on"),
    "publish_clock": (False, "Tell the time of the run on /clock, for nodes with use_sim_time"),
    "prometheus.address": ("127.0.0.1", "Address on which metrics are served; 0.0.0.0 is all of this machine"),
}
PORT = Quantity("", 0, 65535, "the port on which metrics are served, 0 for none,")
WATCHED = {"impact": ImpactSettings, "diagnostics": Limits}
"""What is watched, by the first part of the names of its parameters."""
DECIMATED = ("contact_forces", "axle_stress")
"""Topics that may be decimated."""
OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")


@dataclass(frozen=True)
class Watching:
    """What is worth telling."""

    impact: ImpactSettings
    limits: Limits


class Parameters:
    """The parameters that a node declares, and what they describe."""

    def __init__(self, node: Node) -> None:
        """Declare all parameters of ``node``; raises InputError if one given at the start cannot be used."""
        self._node = node
        self.following = False
        """Whether parameters are being set to what another way has changed already."""
        for name, (default, description) in START_UP.items():
            self._declare(name, default, ParameterDescriptor(description=description, read_only=True))
        self.file = load_scenario(self["scenario"])
        """The scenario without parameters."""
        self._listed = self.file.irregularities  # of which the parameters show the first of each wheel
        for name, value in values_of(self.file).items():
            self._declare(name, value, _number(_quantity(name)))
        for field in dataclasses.fields(Pace):
            quantity = quantity_of(Pace, field.name)
            self._declare(field.name, field.default, _number(quantity, read_only=field.name == "duration"))
        for topic in DECIMATED:
            self._declare(
                f"{topic}.decimation", 1, _whole(FACTOR, f"Steps from sample to sample of {topic}: 1 is full rate")
            )
        for prefix, kind in WATCHED.items():
            for field in dataclasses.fields(kind):
                self._declare(f"{prefix}.{field.name}", field.default, _number(quantity_of(kind, field.name)))
        self._declare("prometheus.port", 0, _whole(PORT, PORT.meaning.rstrip(","), read_only=True))
        self._warn_of_unknown()
        self.check_clock(self["use_sim_time"])
        self.changed({}, self.file)
        self.pace({})
        self.watching({})

    def __getitem__(self, name: str) -> Any:
        """Value of a parameter."""
        return self._node.get_parameter(name).value

    def changed(self, changes: Values, scenario: Scenario) -> Scenario:
        """``scenario`` with the parameters and ``changes`` of them; raises InputError that names the parameter.

        A speed among the changes ends its speed plan, also if it is the one that the plan begins with.
        """
        values = {name: self[name] for name in values_of(self.file)} | dict(changes)
        plan = () if "speed" in changes else scenario.speed_plan
        return with_values(dataclasses.replace(scenario, irregularities=self._listed, speed_plan=plan), values)

    def follow(self, scenario: Scenario) -> None:
        """Show a scenario that was set by other means than parameters.

        Those of damage show the first breakout of each wheel; a parameter that is set replaces it, the further stay.
        """
        shown = values_of(scenario)
        if self.changed({}, scenario).irregularities == scenario.irregularities:
            shown = {name: shown[name] for name in SCENARIO_NUMBERS}
        else:
            self._listed = scenario.irregularities
        self.following = True
        try:
            different = [Parameter(name, value=value) for name, value in shown.items() if self[name] != value]
            self._node.set_parameters_atomically(different)
        finally:
            self.following = False

    def check_clock(self, use_sim_time: bool) -> None:
        """Raises InputError if the node cannot have its time on ``/clock``."""
        if use_sim_time and self["publish_clock"]:
            raise InputError(
                "use_sim_time = true is refused while publish_clock is true: "
                "a node cannot follow the clock that it publishes, set one of them to false"
            )

    def pace(self, changes: Values) -> Pace:
        """Pace with ``changes`` made; raises InputError that names the parameter."""
        values = {field.name: self[field.name] for field in dataclasses.fields(Pace)} | dict(changes)
        return Pace(**{field.name: values[field.name] for field in dataclasses.fields(Pace)})

    def watching(self, changes: Values) -> Watching:
        """What is worth telling with ``changes`` made, all checked; raises InputError that names the parameter."""
        made = []
        for prefix, kind in WATCHED.items():
            names = {field.name: f"{prefix}.{field.name}" for field in dataclasses.fields(kind)}
            try:
                made.append(kind(**{key: changes.get(name, self[name]) for key, name in names.items()}))
            except InputError as refusal:
                raise InputError(f"{prefix}.{refusal}") from None
        return Watching(*made)

    def decimation(self, changes: Values) -> dict[str, int]:
        """Steps from sample to sample of each topic in ``DECIMATED`` with ``changes`` made."""
        names = {topic: f"{topic}.decimation" for topic in DECIMATED}
        return {topic: changes[name] if name in changes else self[name] for topic, name in names.items()}

    def _declare(self, name: str, default: Any, descriptor: ParameterDescriptor) -> None:
        try:
            self._node.declare_parameter(name, default, descriptor)
        except InvalidParameterTypeException:
            kind = {
                float: "a number with a decimal point, such as 1.0",
                int: "a whole number, such as 10",
                bool: "true or false",
                str: "text",
            }
            raise InputError(f"parameter {name} is of the wrong type: give {kind[type(default)]}") from None
        except InvalidParameterValueException as refusal:
            raise InputError(" ".join(str(refusal).split())) from None

    def _warn_of_unknown(self) -> None:
        """A name that nobody declared may be a slip, or in a file shared with other nodes: it is not refused."""
        for name in _overrides(self._node):
            if not self._node.has_parameter(name) and not name.startswith(OF_ROS):
                self._node.get_logger().warning(f"parameter {name} is not known and not used")


def _quantity(name: str) -> Quantity:
    *damage, last = name.split(".")
    return quantity_of(Breakout if damage else Scenario, last)


def _number(quantity: Quantity, *, read_only: bool = False) -> ParameterDescriptor:
    unit = f", {quantity.unit}" if quantity.unit else ""
    return ParameterDescriptor(
        description=f"{quantity.meaning.rstrip(',')}{unit}",
        read_only=read_only,
        floating_point_range=[FloatingPointRange(from_value=float(quantity.low), to_value=float(quantity.high))],
    )


def _whole(quantity: Quantity, description: str, *, read_only: bool = False) -> ParameterDescriptor:
    limits = IntegerRange(from_value=int(quantity.low), to_value=int(quantity.high))
    return ParameterDescriptor(description=description, read_only=read_only, integer_range=[limits])


def _overrides(node: Node) -> Iterable[str]:
    return getattr(node, "_parameter_overrides", {})
