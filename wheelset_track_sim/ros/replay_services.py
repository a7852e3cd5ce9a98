"""Services of the replay node: pause, resume, steps and seeking, also under the names of ``ros2 bag play``."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from importlib import import_module
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from ..errors import WheelsetTrackError
from ..live.player import Player
from .answers import Answer, served

ROSBAG2_PLAYER = "/rosbag2_player"
"""Name of the node of ``ros2 bag play``, below which tools look for its services."""


class ReplayServices:
    """Servers of one node, which answer when a request is done.

    The services of ``ros2 bag play`` need its interfaces, which PyPI does not have.
    """

    def __init__(self, node: Node, player: Player, position: Callable[[], float], finish: Callable[[], None]) -> None:
        """Services of ``node`` that control ``player``.

        ``position`` returns the time in the bag that has been reached, s; ``finish`` ends the replay.
        """
        self._node, self._player, self._position, self._finish = node, player, position, finish
        self._log, self._group = node.get_logger(), MutuallyExclusiveCallbackGroup()
        for name, action in (
            ("pause", player.pause),
            ("resume", player.resume),
            ("toggle_paused", player.toggle),
            ("play_next", player.step),
            ("reset", player.restart),
        ):
            self._serve(name, partial(self._where, action))
        self._serve("stop", self._stop)
        try:
            interfaces = import_module("rosbag2_interfaces.srv")
        except ModuleNotFoundError:
            return
        self._serve_as_rosbag2(interfaces)

    def _serve(self, name: str, answer: Callable[[Any], Answer]) -> None:
        callback = partial(served, self._log, name, answer)
        self._node.create_service(Trigger, f"~/{name}", callback, callback_group=self._group)

    def _serve_as_rosbag2(self, interfaces: Any) -> None:
        player = self._player
        for kind, name, answer in (
            ("Pause", "pause", lambda _: _done(player.pause())),
            ("Resume", "resume", lambda _: _done(player.resume())),
            ("TogglePaused", "toggle_paused", lambda _: _done(player.toggle())),
            ("IsPaused", "is_paused", lambda _: {"paused": player.paused}),
            ("PlayNext", "play_next", lambda _: {"success": player.burst(1).result() == 1}),
            ("Burst", "burst", lambda request: {"actually_burst": player.burst(request.num_messages).result()}),
            ("Seek", "seek", lambda request: _done(player.seek(_ns(request.time)), success=True)),
            ("SetRate", "set_rate", lambda request: _done(player.set_rate(request.rate), success=True)),
            ("GetRate", "get_rate", lambda _: {"rate": player.rate}),
            ("Stop", "stop", self._stop),
        ):
            self._node.create_service(
                getattr(interfaces, kind),
                f"{ROSBAG2_PLAYER}/{name}",
                partial(self._filled, answer),
                callback_group=self._group,
            )

    def _where(self, action: Callable[[], Future[Any]], request: Any) -> Answer:
        action().result()
        stands = "paused" if self._player.paused else "running"
        return {"message": f"{stands} at {self._position():.3f} s"}

    def _stop(self, request: Any) -> Answer:
        self._finish()
        return {}

    def _filled(self, answer: Callable[[Any], Answer], request: Any, response: Any) -> Any:
        """``response`` with an answer; as it is, which says that nothing was done, if it is refused."""
        try:
            for name, value in answer(request).items():
                setattr(response, name, value)
        except WheelsetTrackError as refusal:
            self._log.warning(str(refusal))
        return response


def _done(future: Future[Any], **fields: Any) -> Answer:
    future.result()
    return fields


def _ns(time: Any) -> int:
    return int(time.sec) * 10**9 + int(time.nanosec)
