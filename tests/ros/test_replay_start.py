"""A replay begins when those who wait for it have been found, or when its time has come."""

import pytest

from support.replaying import Subscriber, by_topic, recorded
from wheelset_track_sim.ros.replay_start import Start


class Publisher:
    def __init__(self):
        self.matched = 0

    def get_subscription_count(self):
        return self.matched


def begins(start, matched):
    """Time at which it begins, s; ``matched`` are numbers of subscriptions by the time from which on they are so."""
    publisher, now = Publisher(), 0.0
    ready = start.ready([publisher, Publisher()], lambda: now)
    while not ready():
        now += 0.1
        publisher.matched = max((n for at, n in matched.items() if now >= at - 1e-6), default=0)
    return now


@pytest.mark.parametrize(
    ("delay", "wait", "matched", "at"),
    [
        (0.0, 2.0, {}, 2.0),  # nobody is there
        (0.0, 2.0, {0.3: 1}, 0.8),
        (0.0, 2.0, {0.3: 1, 0.6: 2, 1.0: 3}, 1.5),  # each may be the last one
        (0.0, 2.0, {1.8: 1}, 2.0),
        (0.0, 0.0, {0.3: 1}, 0.0),
        (3.0, 2.0, {0.3: 1}, 3.0),
        (1.0, 5.0, {2.0: 1}, 2.5),
    ],
)
def test_when_it_begins(delay, wait, matched, at):
    assert begins(Start(delay, wait), matched) == pytest.approx(at, abs=0.11)


@pytest.mark.ros
@pytest.mark.slow
@pytest.mark.timeout(300)
def test_those_who_wait_for_it_hear_all(start, client, short_bag):
    listener = Subscriber(client, short_bag)
    replay = start(short_bag, "--wait", 60, "--rate", 5, program="replay")
    assert replay.wait() == 0, replay.errors
    stored = by_topic(recorded(short_bag))
    client.until(lambda: len(listener.arrived) >= sum(map(len, stored.values())))
    assert {topic: items[-len(stored[topic]) :] for topic, items in by_topic(listener.arrived).items()} == stored
