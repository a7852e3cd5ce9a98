"""The replay node and its process: it publishes the messages of a bag as the recorded node did."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.validate_full_topic_name import validate_full_topic_name

from ..bags.bag_writer import PREFIX
from ..bags.playback.recorded_bag import Played, RecordedBag
from ..bags.playback.selection import Selection
from ..bags.playback.stamps import Restamping, stamp_of, stampable, with_stamp
from ..bags.topics import Topic
from ..errors import InputError, RecordingError, WheelsetTrackError, printable
from ..live.player import Player
from .acknowledged import wait_for_subscribers
from .answers import answer_always
from .clock import TOPIC as CLOCK
from .clock import NodeClock
from .hosting import Ending, next_ending, own_arguments, refusing, session, spinning
from .replay_parameters import ReplayParameters
from .replay_services import ReplayServices

NAME = PREFIX.strip("/")
ANSWER_TIME = 1.0
"""Time for the client of ``stop`` to receive the answer before the node ends, s."""


class ReplayNode(Node):  # type: ignore[misc]
    """A bag that is played with the topics, types, qualities of service and bytes of the recorded node.

    Parameters are in ``replay_parameters``, services in ``replay_services``.
    """

    def __init__(self, end: Callable[[Exception | None], None], given: Mapping[str, Any], name: str = NAME) -> None:
        """``given`` overrides parameters of ROS; ``end`` is called at the end of the bag.

        Raises InputError for parameters that cannot be used, RecordingError for a bag that cannot be played.
        """
        super().__init__(name, parameter_overrides=[Parameter(key, value=value) for key, value in given.items()])
        self._end = end
        self.parameters = ReplayParameters(self)
        self._interrupted = False
        self._reported = 0  # damages that have been logged
        self._origin_ns = 0
        self._begun = False
        self._thread = threading.Thread(target=self._play, name="replay")
        self._time = NodeClock(self, publish=self.parameters["publish_clock"])
        self._restamping = Restamping() if self.parameters["stamps"] == "now" else None
        with ExitStack() as stack:
            self._bag = stack.enter_context(RecordedBag(Path(self.parameters["bag"]).expanduser()))
            self._topics = self._playable()
            self.selection = Selection(self._bag, self._topics)
            playback = self.parameters.playback()
            self.player = Player(self.selection, playback, self._deliver, self._moved, self._on_end, self._time)
            if self.parameters["position"] != playback.start_offset:
                self.seek(self.parameters["position"])
            self._outlets = {topic.name: self._publisher(topic) for topic in self._topics.values()}
            stack.pop_all()
        ReplayServices(self, self.player, self.position, self.finish)
        answer_always(self)
        self.add_on_set_parameters_callback(self._on_parameters)

    def begin(self) -> None:
        """Play as soon as there is a time on the clock."""
        self._thread.start()

    def finish(self) -> None:
        """End the replay at once."""
        self.player.stop()
        self._end(None)

    def close(self) -> None:
        """Stop; not to be called from a callback."""
        self._interrupted = True
        self.player.stop()
        self._time.wake()
        if self._thread.ident is not None:
            self._thread.join()
        self._bag.close()

    def seek(self, position: float) -> Future[None]:
        """Continue from a time in the bag, s; raises InputError for one that is not played."""
        return self.player.seek(self.selection.start_ns + round(position * 1e9))

    def position(self) -> float:
        """Time in the bag that has been reached, s."""
        return (self.player.position_ns - self.selection.start_ns) * 1e-9

    def _playable(self) -> dict[str, Topic]:
        """Topics that can be published here; the others are logged. Raises InputError if there are none."""
        found: dict[str, Topic] = {}
        left_out = []
        for name, topic in self._bag.topics.items():
            reason = _hindrance(topic)
            if name == CLOCK and self.parameters["publish_clock"]:
                reason = "this node publishes the time"
            if reason:
                left_out.append(f"{name}: {reason}")
            else:
                found[name] = topic
        for line in left_out:
            self.get_logger().warning(printable(f"left out: {line}"))
        if not found:
            raise InputError(f"{self._bag.path} holds no topic that can be published here ({'; '.join(left_out)})")
        return found

    def _publisher(self, topic: Topic) -> Any:
        quality = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=topic.depth,
            reliability=ReliabilityPolicy.RELIABLE if topic.reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
        )
        name = self.parameters.renamed(topic, self._bag.topics.values())
        try:
            return self.create_publisher(message_type(topic.type), name, quality)
        except InvalidTopicNameException as refusal:
            raise InputError(f"prefix = {self.parameters['prefix']}: {' '.join(str(refusal).split())}") from None

    def _play(self) -> None:
        if self._time.now_ns() == 0:
            self.get_logger().info(f"waiting for the time on {CLOCK}")
        self._time.wait_for_time(lambda: self._interrupted)
        self._time.warn_of_others()
        self._origin_ns = self._time.now_ns()
        length = (self.selection.end_ns - self.selection.start_ns) * 1e-9
        self.get_logger().info(
            f"playing {printable(str(self._bag.path))}, {len(self._topics)} topics, {length:.3f} s"
            + (", paused" if self.player.paused else "")
        )
        self.player.run(self.parameters.start().ready([*self._outlets.values()]))

    def _moved(self, begin_ns: int, played_ns: int) -> None:
        """In the player's thread: another part of the bag follows, so publish the latched messages in force there."""
        self._report_damages()
        if self._restamping is not None:
            self._restamping.restart()
        for message in self.selection.held_at(begin_ns):
            cdr = message.cdr
            if self._restamping is not None and self._topics[message.topic].stamped and stampable(cdr):
                cdr = with_stamp(cdr, self._origin_ns + played_ns)
            self._outlets[message.topic].publish(cdr)

    def _deliver(self, message: Played, played_ns: int) -> None:
        """In the player's thread: publish a message."""
        if not self._begun:  # stamps of now do not begin while it waits
            self._begun, self._origin_ns = True, self._time.now_ns() - played_ns
        topic = self._topics[message.topic]
        cdr, due_ns = message.cdr, message.time_ns
        if self._restamping is not None:
            due_ns = self._origin_ns + played_ns
            if topic.stamped and stampable(cdr):
                cdr = self._restamping.apply("" if topic.kind else topic.name, cdr, due_ns)
        if self.parameters["publish_clock"] and self.selection.leading in (None, message.topic):
            span = self.selection.span_ns(message) if stampable(cdr) else 0
            self._time.tell(max(due_ns, stamp_of(cdr) + span) if span else due_ns)
        self._outlets[message.topic].publish(cdr)
        self._report_damages()

    def _report_damages(self) -> None:
        for damage in self._bag.damages[self._reported :]:
            self.get_logger().warning(printable(f"damaged: {damage}"))
        self._reported = len(self._bag.damages)

    def _on_end(self, failure: Exception | None) -> None:
        """In the player's thread: the bag ends, or cannot be played any further."""
        wait_for_subscribers(self._outlets.values())
        kept = self.player.punctuality
        self.get_logger().info(f"played {kept.messages} messages, at most {1e3 * kept.worst:.1f} ms late")
        self._end(failure)

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        changes = {item.name: item.value for item in parameters}
        try:
            if changes.get("use_sim_time", self._time.following) != self._time.following:
                raise InputError("use_sim_time cannot change while a bag is played: give it at the start")
            futures = []
            if "loop" in changes:
                self.player.loop = changes["loop"]
            if "rate" in changes:
                futures.append(self.player.set_rate(changes["rate"]))
            if "position" in changes:
                futures.append(self.seek(changes["position"]))
            for future in futures:
                future.result()
        except WheelsetTrackError as refusal:
            return SetParametersResult(successful=False, reason=str(refusal))
        return SetParametersResult(successful=True)


def main(arguments: Sequence[str], given: Mapping[str, Any]) -> int:
    """Play a bag until it ends, or a signal arrives; ``given`` are parameters that override those in ``arguments``.

    Returns 0; raises InputError for arguments or parameters that cannot be used, WheelsetTrackError for the bag.
    """
    own = own_arguments(arguments)
    if own:
        raise InputError(f"{own[0]} is not an argument of the replay: see wheelset-track-sim replay --help")
    with session(arguments) as endings, ExitStack() as stack:
        with refusing():
            node = ReplayNode(lambda failure: endings.put(Ending(0, failure)), given)
        stack.callback(node.destroy_node)
        executor = SingleThreadedExecutor()
        stack.callback(executor.shutdown)
        executor.add_node(node)
        with spinning(executor):
            try:
                node.begin()
                by, failure = next_ending(endings)
                if by is not None:
                    time.sleep(ANSWER_TIME)
            finally:
                node.close()
    if failure is not None and not isinstance(failure, WheelsetTrackError):
        raise RecordingError(f"{given.get('bag', 'the bag')} cannot be played further: {failure!r}") from failure
    if failure is not None:
        raise failure
    return 0


def _hindrance(topic: Topic) -> str:
    """Why a topic cannot be published here; empty if it can."""
    if topic.outdated:
        return f"{topic.type} has been changed since it was recorded"
    try:
        message_type(topic.type)
    except (ImportError, AttributeError):
        return f"{topic.type} is not installed"
    try:
        validate_full_topic_name(topic.name)
    except InvalidTopicNameException as reason:
        return " ".join(str(reason).split())
    return ""


def message_type(kind: str) -> Any:
    """Class of a message by the full name of its type; raises ImportError if it is not installed.

    A bag names any type it likes, so nothing is imported but packages that rosidl has generated.
    """
    found = re.fullmatch(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)", kind)
    spec = PathFinder.find_spec(found[1]) if found else None
    folders = (spec and spec.submodule_search_locations) or ()
    if not found or not any(True for each in folders for _ in Path(each).glob(f"{found[1]}_s__rosidl_typesupport_*")):
        raise ImportError(f"{kind} is not a message of an installed package")
    return getattr(import_module(f"{found[1]}.msg"), found[2])
