"""A real recorder in real processes that are killed: ``python -m support.killed_recorder FOLDER COUNT SEED``.

One process loads the simulator and all libraries; each child of it streams at real time, records as the node does,
and is killed. Tells for each bag the simulated time that had been handed over then, s.
"""

import json
import mmap
import os
import random
import signal
import struct
import sys
import time
from pathlib import Path

from wheelset_track_sim.bags.buffered import BufferedWriter
from wheelset_track_sim.bags.messages import chunk_messages, state_message
from wheelset_track_sim.bags.settings import RecordSettings
from wheelset_track_sim.bags.snapshots import writer_of
from wheelset_track_sim.live.pacing import Pace
from wheelset_track_sim.live.run_messages import run_info, state
from wheelset_track_sim.live.stream import Stream
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

TIME = struct.Struct("d")
PATIENCE = 60.0


def record(path, simulator, settings, handed_over, chunk_duration):
    """Record without end."""
    writer = writer_of(path, run_info(simulator), settings, start_ns=0)
    buffered = BufferedWriter(writer, settings.buffer_size, lambda reason, ended: os.abort())
    buffered.put([state_message(state(simulator), 0)])

    def deliver(block, timing):
        buffered.put(chunk_messages(block, 0))
        handed_over[:] = TIME.pack(block.time + len(block) * block.step_period)

    Stream(simulator, Pace(chunk_duration=chunk_duration), deliver, lambda failure: os.abort()).start()
    time.sleep(PATIENCE)
    os.abort()


def main(folder, count, seed):
    chance = random.Random(seed)
    simulator = Simulator(load_scenario("damage_wheel_1"))
    with writer_of(folder / "warm", run_info(simulator), RecordSettings(), start_ns=0) as writer:
        writer.write_state(state(simulator))
        writer.write(simulator.advance(1))
    for number in range(count):
        handed_over = mmap.mmap(-1, TIME.size)
        chunk_duration = chance.choice([0.005, 0.05, 0.15])
        settings = RecordSettings(max_size=10**6 if number % 2 else 0)
        path = folder / f"bag_{number}"
        child = os.fork()
        if child == 0:
            record(path, simulator, settings, handed_over, chunk_duration)
        limit = time.monotonic() + PATIENCE
        while TIME.unpack(handed_over[:])[0] == 0 and time.monotonic() < limit:
            time.sleep(0.001)
        time.sleep(chance.uniform(0.0, 0.4))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        assert os.waitstatus_to_exitcode(status) == -signal.SIGKILL
        print(json.dumps([str(path), TIME.unpack(handed_over[:])[0]]), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
