"""From the messages of ``recording`` to those of ROS: the types; the bytes are the same."""

from __future__ import annotations

from typing import Any

import wheelset_track_msgs.msg


def message_type(kind: str) -> Any:
    """Class of a message of this project by its short name, such as ``AxleStress``."""
    return getattr(wheelset_track_msgs.msg, kind)
