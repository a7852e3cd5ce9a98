"""Peaks by turns: those of the turns as a whole, for any cut of the stream."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.samples.turns import TurnWatch

TURN = 100


def cut(block, borders):
    """Pieces of a block."""
    for start, stop in zip([0, *borders], [*borders, len(block)], strict=True):
        yield dataclasses.replace(
            block,
            first_step=block.first_step + start,
            time=block.time + start * block.step_period,
            forces=block.forces[start:stop].copy(),
            stresses=block.stresses[start:stop].copy(),
        )


def test_nothing_is_known_before_the_first_turn(make_block):
    watch = TurnWatch(TURN)
    assert watch.push(make_block(0, TURN - 1)) == []
    assert watch.last.turns == 0
    assert all(map(math.isnan, watch.last.forces))
    (found,) = watch.push(make_block(TURN - 1, 1))
    assert found == watch.last
    assert found.turns == 1


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])  # the fixture is a function
@given(st.integers(0, 250), st.integers(1, 900), st.lists(st.integers(1, 899), max_size=30), st.booleans())
def test_peaks_are_those_of_whole_turns_for_any_cut(make_block, first, samples, borders, summaries):
    whole = make_block(first, samples)
    watch = TurnWatch(TURN)
    pieces = cut(whole, sorted({border for border in borders if border < samples}))
    found = [peaks for piece in pieces for peaks in watch.push(piece, summarise(piece) if summaries else None)]
    starts = [step for step in range(0, first + samples, TURN) if first <= step <= first + samples - TURN]
    assert [peaks.turns for peaks in found] == [start // TURN + 1 for start in starts]
    for peaks, start in zip(found, starts, strict=True):
        rows = slice(start - first, start - first + TURN)
        assert peaks.forces == tuple(whole.forces[rows].max(axis=0))
        assert peaks.principal == tuple(whole.max_principal[rows].max(axis=0))


def test_decimated_blocks_are_refused(make_block):
    with pytest.raises(ValueError, match="every 4th"):
        TurnWatch(TURN).push(dataclasses.replace(make_block(0, 10), decimation=4))


def test_a_damaged_wheel_has_its_peak_in_each_turn(damaged):
    watch = TurnWatch(damaged.steps_per_revolution)
    forces = []
    for _ in range(5):
        block = damaged.advance(damaged.steps_per_revolution // 2)
        forces.append(block.forces)
        watch.push(block)
    assert watch.last.turns == 2
    stream = np.concatenate(forces)
    assert watch.last.forces[0] == stream[damaged.steps_per_revolution : 2 * damaged.steps_per_revolution, 0].max()
    assert watch.last.forces[0] > 1.5 * watch.last.forces[1]
