"""Runs made up of plain numbers, for tests of code that records or shows runs wherever they come from."""

import dataclasses
import math
from pathlib import Path

import numpy as np

from wheelset_track_sim.bags import BagWriter, RunInfo, State
from wheelset_track_sim.samples.block import SampleBlock

DX = 1e-3
NODES = ("A1", "B1", "C1")
RUN_INFO = RunInfo("undamaged", "name: undamaged  # Ångström\nspeed: 27.7777778\n", "0123abcd", 0.6)


def block_of_numbers(
    first_step: int,
    samples: int,
    *,
    time: float = 0.0,
    speed: float = 27.7777778,
    revision: int = 0,
    nodes: tuple[str, ...] = NODES,
) -> SampleBlock:
    """Block whose numbers all differ, by step, wheel, node and component; wheel 2 loses contact now and then."""
    step = np.arange(first_step, first_step + samples, dtype=float)
    forces = np.stack([98.1e3 + 4e3 * np.sin(step / 95), np.maximum(0.0, 9e4 + 1e5 * np.cos(step / 33))], axis=-1)
    weights = np.arange(1.0, len(nodes) * 6 + 1).reshape(len(nodes), 6)
    stresses = 1e6 * weights * np.sin(step / 7)[:, None, None] + 1 / 3
    return SampleBlock(first_step, time, DX / speed, speed, first_step * DX, revision, forces, stresses, nodes)


def state_of_numbers(block: SampleBlock) -> State:
    return State(
        first_step=block.first_step,
        time=block.time,
        step_period=block.step_period,
        speed=block.speed,
        speed_set_point=30.0,
        position=block.position,
        revision=block.revision,
        axle_load=196200.0,
        damage=({"wheel": 1, "kind": 0, "a": 0.03, "b": 0.024, "h": 0.002, "angle": 0.5, "y": -0.001},),
        scenario_name="undamaged",
        scenario=f"name: undamaged  # Ångström\nspeed: {block.speed}\n",
        digest="0123abcd",
        real_time_factor=math.inf,
    )


def small_run(path: Path, *, chunks: int, length: int) -> tuple[list[SampleBlock], list[State], RunInfo]:
    """Record a bag with a chunk of the file for each block; the blocks, states and origin that are in it."""
    info = RUN_INFO
    blocks: list[SampleBlock] = []
    for number in range(chunks):
        time = blocks[-1].time + length * blocks[-1].step_period if blocks else 0.0
        blocks.append(block_of_numbers(number * length, length, time=time, revision=number // 4))
    states = [dataclasses.replace(state_of_numbers(block), scenario=info.scenario) for block in blocks[::4]]
    with BagWriter(path, info, start_ns=1_700_000_000_123_456_789) as writer:
        for number, block in enumerate(blocks):
            if number % 4 == 0:
                writer.write_state(states[number // 4])
            writer.write(block)
            writer._file.flush()
    return blocks, states, info
