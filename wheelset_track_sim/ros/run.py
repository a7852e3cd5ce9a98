"""One run of the node, from its step 0 on: what streams is told and recorded here."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..bags.messages import State, chunk_messages, impact_message, state_message
from ..errors import InputError, RecordingError
from ..live.origin import state, states
from ..live.pacing import Pace
from ..live.recorder import Recorder
from ..live.stream import Stream, Timing
from ..samples.block import SampleBlock
from ..samples.summary import summarise
from ..simulation.instants import Contacts
from ..simulation.simulator import Simulator
from .clock import NodeClock
from .monitoring import Monitoring
from .outputs import Outputs

RUNNING, PAUSED, FAILED = range(3)
"""Status in SimulationState."""


class Run:
    """A simulator that streams while it runs and stands while it is paused; no sample is lost between the two.

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
    ) -> None:
        """``ended`` is called in the stream's thread if the run is over by itself, or cannot go on."""
        self.simulator = simulator
        self.contacts = Contacts()
        self.start_ns = 0
        """Time stamp of step 0, ns."""
        self._outputs, self._monitoring, self._recorder, self._log = outputs, monitoring, recorder, log
        self._clock, self._ended = clock, ended
        self._stream: Stream | None = None
        self._next_step = simulator.next_step
        self._told: State | None = None
        self._due = False  # the state, with the next chunk
        self._over = False  # its topics go
        self._lock = threading.RLock()  # between two chunks: what is told, recorded and remembered of a chunk is whole

    @property
    def running(self) -> bool:
        """Whether it streams."""
        return self._stream is not None

    @property
    def next_step(self) -> int:
        """First step that is not delivered yet."""
        return self._next_step

    @property
    def end_ns(self) -> int:
        """Time stamp behind the last sample, ns."""
        return self.start_ns + round(self.simulator.course.time_of(self._next_step) * 1e9)

    def go_on(self, pace: Pace) -> None:
        """Stream from where the run stands."""
        self._tell(state(self.simulator), RUNNING)
        self._monitoring.run()
        self._stream = Stream(self.simulator, pace, self._deliver, self._on_end, self._clock)
        self._stream.start()

    def set_pace(self, pace: Pace) -> None:
        """Another pace, from the next chunk on."""
        stream = self._stream
        if stream is not None:
            stream.set_pace(pace)

    def pause(self) -> None:
        """Hand over the chunk at hand, then stand."""
        self._stop()
        if self._told is None or self._told.status != FAILED:
            self.stand("paused")

    def stand(self, why: str) -> None:
        """Tell that the run stands."""
        self._tell(state(self.simulator), PAUSED)
        self._monitoring.pause(why)

    def end(self) -> None:
        """Stop for good; tell what filters and detectors hold back. Ending again does nothing."""
        self._stop()
        with self._lock:
            self._over = True
        self._finish()

    def start_recording(self, path: Path) -> int:
        """Open a bag; returns the first step that it will hold. Raises InputError."""
        bag = self._recorder.open(path, self.simulator, self.start_ns)  # the stream waits for no disk
        with self._lock:
            if self._over:  # meanwhile: nobody would close the bag
                bag.discard()
                raise InputError("the run is over: start the recording in the next one")
            self._recorder.take(bag)
            self._tell_again()
            return self._next_step

    def split_recording(self) -> Path:
        """Go on in the next file of the bag, which begins with the state; raises InputError or RecordingError."""
        with self._lock:
            split = self._recorder.split()
            self._tell_again()
        return split.result()

    def take_snapshot(self) -> Path:
        """Write the latest messages; returns where. Raises InputError or RecordingError."""
        return self._recorder.snapshot().result()

    def stop_recording(self) -> str:
        """Close the bag, if one is open; returns its path. Raises RecordingError."""
        with self._lock:
            stopped = self._recorder.stop()
            self._tell_again()
        return stopped.result()

    def _stop(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.stop()

    def _deliver(self, block: SampleBlock, timing: Timing) -> None:
        """In the stream's thread: record and publish a chunk, and before it the state if it has changed."""
        summary = summarise(block)
        seen = self._monitoring.push(block, summary, timing)
        messages = chunk_messages(
            block,
            self.start_ns,
            real_time_factor=timing.real_time_factor,
            lag=timing.lag,
            summary=summary,
            turn=seen.turn,
        )
        messages += [impact_message(impact, self.start_ns) for impact in seen.impacts]
        with self._lock:
            if self._due or self._told is None or self._changed(self._told, block):
                told = block.revision if self._told is None else self._told.revision
                for found in states(self.simulator, block, told):
                    self._tell(found, RUNNING, timing)
            self._next_step = block.first_step + len(block)
            self._clock.tell(self.end_ns)
            self._recorder.write(messages)
            self._outputs.publish_chunk(block, messages, self.start_ns)
            self.contacts.push(self.simulator, block)

    def _tell(self, found: State, status: int, timing: Timing | None = None, message: str = "") -> None:
        timing = timing or Timing(float("nan"), 0.0)
        with self._lock:
            self._told = replace(
                found,
                status=status,
                message=message,
                real_time_factor=timing.real_time_factor,
                lag=timing.lag,
                recording=self._recorder.path,
            )
            self._due = False
            messages = [state_message(self._told, self.start_ns)]
            self._recorder.write(messages)
            self._outputs.publish(messages)

    def _tell_again(self) -> None:
        """Tell the state with the next chunk, or at once if there is none on the way."""
        told = None if self._over else self._told
        self._due = told is not None and told.status == RUNNING
        if told is not None and not self._due:
            self._tell(told, told.status, message=told.message)

    def _changed(self, told: State, block: SampleBlock) -> bool:
        set_point = self.simulator.course.at(block.first_step).set_point
        now = block.revision, set_point, self._recorder.path
        return (told.revision, told.speed_set_point, told.recording) != now

    def _finish(self) -> None:
        impacts = [impact_message(impact, self.start_ns) for impact in self._monitoring.finish()]
        self._recorder.write(impacts)
        self._outputs.publish(impacts)
        self._outputs.finish()

    def _on_end(self, failure: Exception | None) -> None:
        """In the stream's thread: the run is over by itself, or the simulation cannot go on."""
        self._finish()
        if failure is not None:
            self._log.error(f"the simulation stopped: {failure!r}")
            self._tell(state(self.simulator), FAILED, message=str(failure))
            self._monitoring.fail(str(failure))
            with suppress(RecordingError):
                self._recorder.stop().result()
        self._ended(failure)
