"""The stream's thread with a source that counts steps."""

import threading
import time

import numpy as np
import pytest

from wheelset_track_sim.live.pacing import Pace
from wheelset_track_sim.live.stream import Stream
from wheelset_track_sim.samples.block import SampleBlock

PERIOD = 1e-4
TIMEOUT = 20.0


class Counting:
    """A source whose forces are step numbers; raises at a step if told to."""

    step_period = PERIOD

    def __init__(self, fails_at=None):
        self.step, self.fails_at = 0, fails_at

    @property
    def time(self):
        return self.step * PERIOD

    def advance(self, steps):
        if self.fails_at is not None and self.step + steps > self.fails_at:
            raise ArithmeticError("no solution")
        first, self.step = self.step, self.step + steps
        forces = np.repeat(np.arange(first, self.step, dtype=float)[:, None], 2, axis=1)
        return SampleBlock(first, first * PERIOD, PERIOD, 10.0, 0.0, 0, forces, np.zeros((steps, 0, 6)), ())


class Sink:
    """What was delivered and how the stream ended."""

    def __init__(self):
        self.blocks, self.timings, self.endings = [], [], []
        self.ended = threading.Event()
        self.some = threading.Semaphore(0)

    def deliver(self, block, timing):
        self.blocks.append(block)
        self.timings.append(timing)
        self.some.release()

    def end(self, failure):
        self.endings.append(failure)
        self.ended.set()

    @property
    def steps(self):
        return np.concatenate([block.forces[:, 0] for block in self.blocks])


def test_run_of_given_duration_is_whole_and_ends():
    sink = Sink()
    stream = Stream(Counting(), Pace(chunk_duration=0.03, real_time_factor=0.0, duration=1.0), sink.deliver, sink.end)
    stream.start()
    assert sink.ended.wait(TIMEOUT)
    stream.stop()
    np.testing.assert_array_equal(sink.steps, np.arange(10_000))
    assert sink.endings == [None]


def test_stop_and_go_loses_and_repeats_nothing():
    source, sink = Counting(), Sink()
    for _ in range(5):
        stream = Stream(source, Pace(chunk_duration=0.01, real_time_factor=2.0), sink.deliver, sink.end)
        stream.start()
        for _ in range(3):
            assert sink.some.acquire(timeout=TIMEOUT)
        stream.stop()
        stream.stop()
    np.testing.assert_array_equal(sink.steps, np.arange(source.step))
    assert sink.endings == []


def test_paced_stream_is_never_early():
    sink = Sink()
    started = time.perf_counter()
    stream = Stream(Counting(), Pace(chunk_duration=0.01, real_time_factor=2.0, duration=0.4), sink.deliver, sink.end)
    stream.start()
    assert sink.ended.wait(TIMEOUT)
    assert time.perf_counter() - started >= 0.4 / 2.0
    stream.stop()
    assert all(timing.lag >= 0 for timing in sink.timings)


def test_stop_does_not_wait_for_a_slow_clock():
    sink = Sink()
    stream = Stream(Counting(), Pace(chunk_duration=1.0, real_time_factor=1e-6), sink.deliver, sink.end)
    stream.start()
    stream.stop()
    np.testing.assert_array_equal(sink.steps, np.arange(len(sink.steps)))


def test_new_pace_takes_over_from_a_slow_clock():
    sink = Sink()
    slow = Pace(chunk_duration=0.01, real_time_factor=1e-6)
    stream = Stream(Counting(), slow, sink.deliver, sink.end)
    stream.start()
    stream.set_pace(Pace(chunk_duration=0.02, real_time_factor=0.0, duration=0.5))
    assert sink.ended.wait(TIMEOUT)
    stream.stop()
    np.testing.assert_array_equal(sink.steps, np.arange(5000))
    assert len(sink.blocks[1]) == 200


@pytest.mark.parametrize("where", ["source", "sink"])
def test_failure_ends_the_stream_and_is_handed_over(where):
    sink = Sink()

    def deliver(block, timing):
        sink.deliver(block, timing)
        if where == "sink" and len(sink.blocks) == 3:
            raise ArithmeticError("disk is full")

    source = Counting(fails_at=250 if where == "source" else None)
    stream = Stream(source, Pace(chunk_duration=0.01, real_time_factor=0.0), deliver, sink.end)
    stream.start()
    assert sink.ended.wait(TIMEOUT)
    stream.stop()
    assert len(sink.blocks) == (2 if where == "source" else 3)
    assert [type(failure) for failure in sink.endings] == [ArithmeticError]


class Stepped:
    """A clock that goes when it is told to."""

    def __init__(self):
        self.time, self.epoch = 0.0, 0
        self.sleeping = threading.Semaphore(0)
        self.wake = None

    def now(self):
        return self.time

    def sleep(self, due, wake):
        self.wake = wake
        self.sleeping.release()
        if self.time < due:
            wake.wait()

    def go(self, time, epoch=0):
        self.time, self.epoch = time, epoch
        self.wake.set()


@pytest.fixture
def stepped():
    clock, sink = Stepped(), Sink()
    stream = Stream(Counting(), Pace(chunk_duration=0.01, real_time_factor=2.0), sink.deliver, sink.end, clock)
    stream.start()
    assert clock.sleeping.acquire(timeout=TIMEOUT)
    yield clock, sink, stream
    stream.stop()


def test_stream_follows_a_clock_and_stands_with_it(stepped):
    clock, sink, stream = stepped
    assert not sink.blocks
    clock.go(0.0501)  # ten chunks are due
    for _ in range(10):
        assert sink.some.acquire(timeout=TIMEOUT)
    assert clock.sleeping.acquire(timeout=TIMEOUT)
    clock.go(0.0502)  # none is
    assert clock.sleeping.acquire(timeout=TIMEOUT)
    assert len(sink.blocks) == 10
    assert sink.timings[0].lag == pytest.approx(0.0451)
    assert sink.timings[0].real_time_factor == pytest.approx(0.01 / 0.0501)
    stream.stop()  # hands over the chunk at hand, although the clock stands
    np.testing.assert_array_equal(sink.steps, np.arange(1100))


def test_clock_set_back_does_not_hold_the_stream(stepped):
    clock, sink, _ = stepped
    clock.go(10.0)
    for _ in range(20):
        assert sink.some.acquire(timeout=TIMEOUT)
    clock.go(1.0, epoch=1)
    while sink.some.acquire(timeout=0.2):  # what was due before
        pass
    now, limit = 1.0, time.monotonic() + TIMEOUT
    while not sink.some.acquire(timeout=0.05):
        assert time.monotonic() < limit, "it waits for the time that was"
        now += 0.02  # in the end far from the 10 s from which it was set back
        clock.go(now, epoch=1)
    assert now < 10.0
    np.testing.assert_array_equal(sink.steps, np.arange(len(sink.steps)))
