"""How nodes declare their parameters: described, with the limits of the package's own quantities."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

from ..errors import InputError
from ..inputs.schema import Quantity

OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
KINDS = {
    float: "a number with a decimal point, such as 1.0",
    int: "a whole number, such as 10",
    bool: "true or false",
    str: "text",
}


def declare(node: Node, name: str, default: Any, descriptor: ParameterDescriptor) -> None:
    """Declare a parameter of ``node``; raises InputError if the one given at the start cannot be used."""
    try:
        node.declare_parameter(name, default, descriptor)
    except InvalidParameterTypeException:
        raise InputError(f"parameter {name} is of the wrong type: give {KINDS[type(default)]}") from None
    except InvalidParameterValueException as refusal:
        raise InputError(" ".join(str(refusal).split())) from None


def fixed(description: str) -> ParameterDescriptor:
    """Descriptor of what is given at the start or not at all."""
    return ParameterDescriptor(description=description, read_only=True)


def flag(description: str) -> ParameterDescriptor:
    """Descriptor of what is so or not, at any time."""
    return ParameterDescriptor(description=description)


def described(quantity: Quantity) -> str:
    """Meaning of a quantity with its unit."""
    unit = f", {quantity.unit}" if quantity.unit else ""
    return f"{quantity.meaning.rstrip(',')}{unit}"


def number(quantity: Quantity, *, read_only: bool = False) -> ParameterDescriptor:
    """Descriptor of a quantity."""
    return ParameterDescriptor(
        description=described(quantity),
        read_only=read_only,
        floating_point_range=[FloatingPointRange(from_value=float(quantity.low), to_value=float(quantity.high))],
    )


def whole(quantity: Quantity, description: str, *, read_only: bool = False) -> ParameterDescriptor:
    """Descriptor of a quantity that is counted."""
    limits = IntegerRange(from_value=int(quantity.low), to_value=int(quantity.high))
    return ParameterDescriptor(description=description, read_only=read_only, integer_range=[limits])


def warn_of_unknown(node: Node) -> None:
    """Warn of names that are not declared: they may be mistyped, or belong to other nodes that share the file."""
    for name in _overrides(node):
        if not node.has_parameter(name) and not name.startswith(OF_ROS):
            node.get_logger().warning(f"parameter {name} is not known and not used")


def _overrides(node: Node) -> Iterable[str]:
    return getattr(node, "_parameter_overrides", {})
