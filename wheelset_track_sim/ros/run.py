"""One run of the node, from its step 0 on: it streams, records and publishes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from ..bags.messages import FRAME, Message
from ..errors import InputError, RecordingError
from ..live.fatigue_watch import FatigueWatch
from ..live.pacing import Pace
from ..live.recorder import Recorder
from ..live.run_messages import FAILED, PAUSED, RUNNING, RunMessages
from ..live.stream import Stream, Timing
from ..samples.block import SampleBlock
from ..samples.impacts import ImpactSettings
from ..samples.summary import summarise
from ..simulation.changes import Applied
from ..simulation.instants import Contacts
from ..simulation.simulator import Simulator
from .clock import NodeClock
from .monitoring import Monitoring
from .outputs import Outputs
from .position import Motion


class NodeRun:
    """A simulator that streams or is paused; no sample is lost between the two.

    Topics, monitoring, recorder and clock are those of the node, and outlive the run.
    """

    def __init__(
        self,
        simulator: Simulator,
        outputs: Outputs,
        monitoring: Monitoring,
        recorder: Recorder,
        clock: NodeClock,
        log: Any,
        ended: Callable[[Exception | None], None],
        impacts: ImpactSettings | None = None,
        happened: Callable[[Applied], None] = lambda applied: None,
        frame: str = FRAME,
        fatigue: FatigueWatch | None = None,
    ) -> None:
        """``ended`` is called in the stream's thread if the run ends or fails; ``impacts`` defines an impact.

        ``happened`` is called there for each event, before the chunk that it begins with is delivered. ``fatigue``
        counts cycles of the axle.
        """
        self.simulator = simulator
        self.contacts = Contacts()
        self.messages = RunMessages(simulator, impacts=impacts, frame=frame, fatigue=fatigue)
        self.frame = frame
        """Frame of all headers."""
        self._outputs, self._monitoring, self._recorder, self._log = outputs, monitoring, recorder, log
        self._clock, self._ended, self._happened = clock, ended, happened
        self._seen = simulator.revision  # newest revision whose event has been handed to ``happened``
        self._stream: Stream | None = None
        self._still = threading.Event()
        self._still.set()
        self._next_step = simulator.next_step
        self._over = False  # no message is published any more
        self._lock = threading.RLock()  # held from the first to the last message of a chunk

    @property
    def running(self) -> bool:
        """Whether it streams."""
        return self._stream is not None

    @property
    def next_step(self) -> int:
        """First step that is not delivered yet."""
        return self._next_step

    @property
    def start_ns(self) -> int:
        """Time stamp of step 0, ns."""
        return self.messages.start_ns

    @property
    def end_ns(self) -> int:
        """End of the last sample, ns."""
        return self.start_ns + round(self.simulator.course.time_of(self._next_step) * 1e9)

    def go_on(self, pace: Pace, steps: int | None = None) -> None:
        """Stream from the next step on; after so many ``steps`` stand still, until ``pause``."""
        self._hand_out_state(RUNNING)
        self._monitoring.run()
        self._still.clear()
        last = None if steps is None else self._next_step + steps
        ended = partial(self._on_end, last)
        self._stream = Stream(self.simulator, pace, self._deliver, ended, self._clock, steps)
        self._stream.start()

    def stands_still(self, patience: float | None = None) -> bool:
        """Wait until the stream has ended, by itself or by others, or until ``patience`` s are over; whether it has."""
        return self._still.wait(patience)

    def set_pace(self, pace: Pace) -> None:
        """Another pace, from the next chunk on."""
        stream = self._stream
        if stream is not None:
            stream.set_pace(pace)

    def pause(self) -> None:
        """Deliver the current chunk, then pause."""
        self._stop()
        if self.messages.told.status != FAILED:
            self.stand("paused")

    def stand(self, why: str) -> None:
        """Report that the run is paused, and ``why``."""
        self._hand_out_state(PAUSED)
        self._monitoring.pause(why)

    def end(self) -> None:
        """Stop for good, and deliver the rest of filters and detectors. Ending again does nothing."""
        self._stop()
        with self._lock:
            self._over = True
        self._finish()

    def start_recording(self, path: Path) -> int:
        """Open a bag; returns the first step that it will hold. Raises InputError."""
        while True:
            described = self.messages.told.revision
            bag = self._recorder.open(path, self.simulator, self.start_ns)  # the stream waits for no disk
            with self._lock:
                if self._over:  # meanwhile: nobody would close the bag
                    bag.discard()
                    raise InputError("the run is over: start the recording in the next one")
                if self.messages.told.revision == described:
                    self._recorder.take(bag)
                    self._repeat_state()
                    return self._next_step
            bag.discard().result()  # a change came into force meanwhile, and the bag does not hold its step

    def split_recording(self) -> Path:
        """Continue in the next file of the bag, which begins with the state; raises InputError or RecordingError."""
        with self._lock:
            split = self._recorder.bag.split()
            self._repeat_state()
        return split.result()

    def take_snapshot(self) -> Path:
        """Write the latest messages; returns where. Raises InputError or RecordingError."""
        return self.begin_snapshot().result()

    def begin_snapshot(self) -> Future[Path]:
        """Write the latest messages without waiting; the result is where. Raises InputError without a bag."""
        return self._recorder.bag.snapshot()

    def stop_recording(self) -> str:
        """Close the bag, if one is open; returns its path. Raises RecordingError."""
        return self.end_recording().result()

    def end_recording(self) -> Future[str]:
        """Close the bag without waiting; the result is its path, or RecordingError."""
        with self._lock:
            stopped = self._recorder.stop()
            self._repeat_state()
        return stopped

    def _stop(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.stop()
        self._still.set()

    def _deliver(self, block: SampleBlock, timing: Timing) -> None:
        """In the stream's thread: record and publish a chunk, and before it the state if it has changed."""
        summary = summarise(block)
        if block.revision != self._seen:
            newer = [each for each in self.simulator.history if self._seen < each.revision.number <= block.revision]
            self._seen = block.revision
            for each in newer:
                if each.event is not None:
                    self._happened(each)
        with self._lock:
            found = self.messages.push(block, summary, timing, recording=self._recorder.path)
            for state in found.states:
                self._hand_out([state])
            self._next_step = block.first_step + len(block)
            self._clock.tell(self.end_ns)
            self._recorder.write(found.chunk)
            self._outputs.publish_chunk(block, found.chunk, self.start_ns)
            self._outputs.publish_position(Motion.at(self.simulator, self._next_step), self.start_ns)
            self.contacts.push(self.simulator, block)
        self._monitoring.push(block, summary, found.events, timing)

    def _hand_out(self, messages: list[Message]) -> None:
        self._recorder.write(messages)
        self._outputs.publish(messages)

    def _hand_out_state(self, status: int, message: str = "") -> None:
        with self._lock:
            self._hand_out([self.messages.state(status=status, message=message, recording=self._recorder.path)])

    def _repeat_state(self) -> None:
        """Repeat the state before the next chunk, or at once if the run is paused."""
        told = self.messages.told
        if told.status == RUNNING:
            self.messages.state_due = True
        elif not self._over:
            self._hand_out_state(told.status, told.message)

    def _finish(self) -> None:
        self._hand_out(self.messages.finish())
        self._outputs.finish()

    def _on_end(self, last: int | None, failure: Exception | None) -> None:
        """In the stream's thread: the run ends, the simulation fails, or the step ``last`` is reached."""
        self._still.set()
        if failure is None and last is not None and self._next_step >= last:
            return
        self._finish()
        if failure is not None:
            self._log.error(f"the simulation stopped: {failure!r}")
            self._hand_out_state(FAILED, str(failure))
            self._monitoring.fail(str(failure))
            with suppress(RecordingError):
                self._recorder.stop().result()
        self._ended(failure)
