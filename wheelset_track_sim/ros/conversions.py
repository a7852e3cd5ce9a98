"""From the plain fields of messages to ROS messages; what the fields are is said in ``recording.messages``."""

from __future__ import annotations

import re
from array import array
from collections.abc import Mapping
from typing import Any

import numpy as np
import wheelset_track_msgs.msg

from ..recording.messages import Message

PACKAGE = "wheelset_track_msgs"


def message_type(kind: str) -> Any:
    """Class of a message of this project by its short name, such as ``AxleStress``."""
    return getattr(wheelset_track_msgs.msg, kind)


def to_ros(message: Message) -> Any:
    """ROS message with the fields of ``message``, bit by bit."""
    return _filled(message_type(message.kind)(), message.fields)


def _filled(target: Any, fields: Mapping[str, Any]) -> Any:
    for name, value in fields.items():
        if isinstance(value, np.ndarray):  # an array.array is taken over as it is; NumPy is copied value by value
            setattr(target, name, array("d", value.tobytes()))
        elif isinstance(value, Mapping):
            _filled(getattr(target, name), value)
        elif isinstance(value, tuple) and all(isinstance(item, Mapping) for item in value):
            setattr(target, name, [_filled(_item_type(target, name)(), item) for item in value])
        else:
            setattr(target, name, value)
    return target


def _item_type(target: Any, name: str) -> Any:
    """Class of the entries of a field ``sequence<wheelset_track_msgs/Kind>``."""
    declared = re.fullmatch(rf"sequence<{PACKAGE}/(\w+)>", target.get_fields_and_field_types()[name])
    assert declared is not None, f"{type(target).__name__}.{name} is not a sequence of {PACKAGE}"
    return message_type(declared[1])
