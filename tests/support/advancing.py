"""Simulators, up to a step."""

from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.simulation.simulator import Simulator


def advance_to(simulator: Simulator, step: int, chunk: int = 1389) -> list[SampleBlock]:
    """Blocks up to ``step``."""
    blocks = []
    while simulator.next_step < step:
        blocks.append(simulator.advance(min(chunk, step - simulator.next_step)))
    return blocks
