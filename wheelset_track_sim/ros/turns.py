"""Requests that wait for one another: taken at once, answered one after the other, refused when too many wait.

A service keeps its requests in a queue of the middleware while its callback runs, and what does not fit into that queue
is dropped without a word: the client waits for ever. So the callback of a service here only takes the request, and a
thread answers it when its turn has come.
"""

from __future__ import annotations

import traceback
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import BoundedSemaphore
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.qos import QoSProfile

WAITING = 100
"""Requests of one kind that may wait."""
REQUESTS = QoSProfile(depth=10 * WAITING)
"""Of services: the middleware has room for requests until they are taken, and for answers until they are received."""
BUSY = f"busy: {WAITING} requests are waiting: try again"


class Turns:
    """The requests of some services, answered one after the other in the order of arrival by a thread of their own."""

    def __init__(self) -> None:
        """Without services yet: ``serve`` adds one."""
        self._thread = ThreadPoolExecutor(1, "turns")
        self._room = BoundedSemaphore(WAITING)

    def serve(self, service: Any) -> None:
        """Answer a service of rclpy from here; its callback group must run one callback at a time."""
        answer, send = service.callback, service.send_response

        def serve(request: Any, response: Any, header: Any) -> None:
            self._room.release()
            try:
                send(answer(request, response), header)
            except InvalidHandle:  # the node has been destroyed meanwhile
                pass
            except Exception:  # noqa: BLE001  the next one must be answered
                get_logger("turns").fatal(traceback.format_exc())

        def taken(both: tuple[Any, Any], header: Any) -> None:
            if not self._room.acquire(blocking=False):
                send(_busy(service.srv_type, *both), header)
                return
            with suppress(RuntimeError):  # closed
                self._thread.submit(serve, *both, header)

        service.callback = lambda request, response: (request, response)
        service.send_response = taken

    def close(self) -> None:
        """Finish what is being answered, and leave the rest unanswered: the node ends."""
        self._thread.shutdown(cancel_futures=True)


def in_turns(node: Node) -> list[Turns]:
    """Have the services of each exclusive callback group of a node answer in turns, but for rclpy's own group."""
    groups: dict[Any, Turns] = {}
    for service in node.services:
        group = service.callback_group
        if isinstance(group, MutuallyExclusiveCallbackGroup) and group is not node.default_callback_group:
            groups.setdefault(group, Turns()).serve(service)
    return list(groups.values())


def _busy(kind: Any, request: Any, response: Any) -> Any:
    if kind is SetParameters:
        response.results = [SetParametersResult(successful=False, reason=BUSY) for _ in request.parameters]
    elif kind is SetParametersAtomically:
        response.result = SetParametersResult(successful=False, reason=BUSY)
    elif hasattr(response, "success"):
        response.success, response.message = False, BUSY
    else:  # of simulation_interfaces
        response.result.result, response.result.error_message = response.result.RESULT_OPERATION_FAILED, BUSY
    return response
