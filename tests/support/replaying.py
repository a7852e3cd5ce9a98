"""What the tests of replays share: what a bag holds, and a subscriber that takes bytes."""

import time
from importlib import import_module
from typing import NamedTuple

from mcap.reader import make_reader

NODE = "/wheelset_track_sim"
LATCHED = {f"{NODE}/state"}
EVERY_CHUNK = ("contact_forces", "axle_stress/a1", "axle_stress/b1", "axle_stress/c1", "summary")


class Stored(NamedTuple):
    time_ns: int
    topic: str
    cdr: bytes
    kind: str


class Arrived(NamedTuple):
    topic: str
    cdr: bytes
    at: float


def padded(cdr):
    """A message as the transport hands it over: with zeros behind it to a multiple of four bytes."""
    return cdr + bytes(-len(cdr) % 4)


def recorded(bag):
    """All messages of a bag, as MCAP's own reader yields them."""
    found = []
    for file in [bag] if bag.is_file() else sorted(bag.glob("*.mcap")):
        with file.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages():
                found.append(Stored(message.log_time, channel.topic, padded(message.data), schema.name))
    return found


def by_topic(items):
    """Bytes in their order on each topic: between topics there is none."""
    found = {}
    for item in items:
        found.setdefault(item.topic, []).append(item.cdr)
    return found


class Subscriber:
    """Takes the bytes of all topics of a bag, under the names that they have now."""

    def __init__(self, client, bag, rename=lambda name: name):
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self.client, self.arrived = client, []
        kinds = {item.topic: item.kind for item in recorded(bag)}
        # Those that are seldom heard of come first: when the others are heard, they are connected too.
        for topic in sorted(kinds, key=lambda name: "impacts" not in name):
            package, _, kind = kinds[topic].partition("/msg/")
            latched = DurabilityPolicy.TRANSIENT_LOCAL if topic in LATCHED else DurabilityPolicy.VOLATILE
            client.node.create_subscription(
                getattr(import_module(f"{package}.msg"), kind),
                rename(topic),
                lambda cdr, topic=topic: self._take(topic, cdr),
                QoSProfile(depth=5000, durability=latched),
                raw=True,
            )

    def _take(self, topic, cdr):
        with self.client.arrived:
            self.arrived.append(Arrived(topic, cdr, time.monotonic()))
            self.client.arrived.notify_all()

    def _latest(self):
        return {item.topic: item.cdr for item in [*self.arrived]}

    def count(self, topic):
        return sum(item.topic.endswith(topic) for item in self.arrived)

    def connect(self):
        """Play chunk after chunk of a paused replay until one has come on each topic, then go back to the beginning."""
        limit = time.monotonic() + 60
        while not all(self.count(topic) for topic in EVERY_CHUNK):
            assert self.client.trigger("play_next").success
            assert time.monotonic() < limit
        assert self.client.trigger("reset").success

    def play_to_the_end(self, stored):
        """Play a paused replay chunk by chunk, each when the one before it has come; all that came.

        A replay at its own pace may overwrite messages that a subscriber on a busy machine has not taken yet.
        """
        [leading] = [topic for topic in stored if topic.endswith("contact_forces")]
        for chunk in stored[leading]:
            assert self.client.trigger("play_next").success
            self.client.until(lambda cdr=chunk: self._latest().get(leading) == cdr)
        self.client.running.clear()  # it ends when it goes on from here
        self.client.trigger("resume")
        self.client.until(lambda: self._latest() == {topic: items[-1] for topic, items in stored.items()})
        found = by_topic(self.arrived)
        return {topic: items[len(items) - 1 - items[::-1].index(stored[topic][0]) :] for topic, items in found.items()}
