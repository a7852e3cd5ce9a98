"""How services of nodes answer: always, whatever happens."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.node import Node

from ..errors import WheelsetTrackError

Answer = dict[str, Any]
"""Fields of a response."""


def served(log: Any, name: str, answer: Callable[[Any], Answer], request: Any, response: Any) -> Any:
    """``response``, which has ``success`` and ``message``, with an answer, or with the reason why there is none.

    A refusal is logged with the ``name`` of the service.
    """
    try:
        fields = {"success": True, **answer(request)}
    except WheelsetTrackError as refusal:
        fields = {"success": False, "message": str(refusal)}
    except Exception as failure:  # noqa: BLE001  the executor must live, and the client must not wait
        log.fatal(traceback.format_exc())
        fields = {"success": False, "message": f"it failed, see the node's log: {failure!r}"}
    if not fields["success"]:
        log.warning(f"{name} is rejected: {fields['message']}")
    for field, value in fields.items():
        setattr(response, field, value)
    return response


def answer_always(node: Node) -> None:
    """Have those services of ``node`` answer, too, that ``rclpy`` brings, whatever they are asked for.

    A transition that the state at hand does not have, or a parameter of no known type, would end the executor: nobody
    would be served any more. The answer is what there is of it by then, at first that nothing was done.
    """
    for service in node.services:
        service.callback = partial(_answered, node.get_logger(), service.srv_name, service.callback)


def _answered(log: Any, name: str, callback: Callable[[Any, Any], Any], request: Any, response: Any) -> Any:
    try:
        return callback(request, response)
    except Exception as refusal:  # noqa: BLE001  the executor must live, and the client must not wait
        log.warning(f"{name} is rejected: {' '.join(str(refusal).split())}")
        return response
