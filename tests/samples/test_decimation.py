"""The decimation filter: tones, stamps, ends, cuts, changes of speed."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.decimation import (
    PASSBAND,
    REACH,
    RIPPLE,
    BlockDecimator,
    Decimator,
    decimated,
    low_pass,
)

FACTORS = (2, 3, 10, 97, 1000)
DX = 1e-3


def steady(factor, frequency, samples=40, phase=0.3):
    """Samples of a tone, cosine and sine, away from both ends; ``frequency`` is relative to half the new rate."""
    steps = np.arange((samples + 2 * REACH) * factor)
    angle = np.pi * frequency * steps / factor + phase
    decimator = Decimator(factor, 0)
    found = np.concatenate([decimator.push(np.stack([np.cos(angle), np.sin(angle)], axis=1)), decimator.finish()])
    kept = np.arange(REACH, REACH + samples)
    return found[kept], np.pi * frequency * kept + phase


@pytest.mark.parametrize(
    ("factor", "frequency"),
    [(factor, tone) for factor in FACTORS for tone in (1.0, 1.02, 1.3, 1.9, 2.0, 2.7, 4.5) if tone <= factor],
)
def test_nothing_above_half_the_new_rate_is_left(factor, frequency):
    found, _ = steady(factor, frequency)
    assert np.abs(found).max() < 1e-4  # 80 dB below 1


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("frequency", [0.0, 0.01, 0.25, 0.5, 0.7, PASSBAND])
def test_pass_band_is_flat_and_stamps_are_without_delay(factor, frequency):
    found, angle = steady(factor, frequency)
    # Both parts of the phasor: an error of amplitude and one of delay would show alike.
    np.testing.assert_allclose(found, np.stack([np.cos(angle), np.sin(angle)], axis=1), rtol=0, atol=RIPPLE)


@pytest.mark.parametrize("factor", FACTORS)
def test_the_whole_stop_band(factor):
    response = low_pass(factor)
    size = np.abs(np.fft.rfft(response, 1 << 21))
    relative = np.linspace(0.0, factor, len(size))
    assert size[relative >= 1].max() < RIPPLE
    assert np.abs(size[relative <= PASSBAND] - 1).max() < RIPPLE
    np.testing.assert_array_equal(response, response[::-1])  # linear phase


@pytest.mark.parametrize("first", [0, 1, 29, 30])
@pytest.mark.parametrize("count", [1, 7, 30, 31, 2000])
def test_a_constant_comes_out_from_the_first_to_the_last_step(first, count):
    decimator = Decimator(10, first)
    step = decimator.next_step
    found = np.concatenate([decimator.push(np.full((count, 1), 98.1e3)), decimator.finish()])
    assert [*range(step, step + 10 * len(found), 10)] == [s for s in range(first, first + count) if s % 10 == 0]
    np.testing.assert_allclose(found, 98.1e3, rtol=1e-13)


def test_delay_is_as_said():
    decimator = Decimator(10, 0)
    assert len(decimator.push(np.ones((REACH * 10, 1)))) == 0
    assert len(decimator.push(np.ones((1, 1)))) == 1
    assert decimator.next_step == 10


@given(
    st.lists(st.integers(1, 200), min_size=1, max_size=12),
    st.integers(2, 60),
    st.integers(0, 500),
    st.integers(1, 5),
)
def test_any_cut_gives_the_same_bits(lengths, factor, first, signals):
    samples = np.random.default_rng(1).normal(size=(sum(lengths), signals))
    runs = []
    for cuts in (lengths, [len(samples)], [1] * len(samples)):
        decimator, found, start = Decimator(factor, first), [], 0
        for length in cuts:
            found.append(decimator.push(samples[start : start + length]))
            start += length
        runs.append(np.concatenate([*found, decimator.finish()]))
    assert np.array_equal(runs[0], runs[1])
    assert np.array_equal(runs[0], runs[2])
    expected = [step for step in range(first, first + len(samples)) if step % factor == 0]
    assert len(runs[0]) == len(expected)


def test_samples_are_the_weighted_means_around_them():
    samples = np.random.default_rng(2).normal(size=3000)
    decimator = Decimator(7, 0)
    found = np.concatenate([decimator.push(samples[:, None]), decimator.finish()])[:, 0]
    held = np.pad(samples, 7 * REACH, mode="edge")
    np.testing.assert_allclose(found, np.convolve(held, low_pass(7), mode="valid")[::7], rtol=0, atol=1e-12)


def cut(run, speeds, lengths):
    """Blocks of a run (steps, 2) whose speed is given for each step; cut there and after ``lengths``."""
    cuts = {0, len(run), *np.cumsum(lengths).tolist(), *(np.flatnonzero(np.diff(speeds)) + 1).tolist()}
    bounds = sorted(bound for bound in cuts if bound <= len(run))
    times = np.concatenate([[0.0], np.cumsum(DX / speeds)])
    for start, end in pairwise(bounds):
        part, speed = run[start:end].copy(), float(speeds[start])
        stresses = np.repeat(part[:, :1], 6, axis=1)[:, None] * np.arange(6)
        revision = int(speed != speeds[0])
        yield (
            SampleBlock(start, float(times[start]), DX / speed, speed, start * DX, revision, part, stresses, ("A1",)),
            times,
        )


@pytest.mark.parametrize("factor", [2, 10, 50])
def test_a_change_of_speed_goes_on_in_steps(factor):
    steps = np.arange(8000)
    run = np.stack([np.cos(0.3 * np.pi * steps / factor), np.sin(0.3 * np.pi * steps / factor)], axis=1)
    speeds = np.select([steps < 2005, steps < 2300, steps < 4111], [27.8, 28.0, 28.2], 30.0)
    given, times = zip(*cut(run, speeds, [100] * 80), strict=True)
    found = list(decimated(given, factor))
    following = 0
    for block in found:
        own = np.arange(block.first_step, block.first_step + factor * len(block), factor)
        assert block.first_step == following
        following = block.first_step + factor * len(block)
        assert block.decimation == factor
        assert set(speeds[own]) == {block.speed}
        assert block.step_period == pytest.approx(factor * DX / block.speed, rel=1e-15)
        assert block.revision == int(block.speed != 27.8)
        np.testing.assert_allclose(block.time + np.arange(len(block)) * block.step_period, times[0][own], rtol=1e-12)
        assert block.position == pytest.approx(block.first_step * DX, rel=1e-12)
        inner = own[(own > REACH * factor) & (own < len(run) - REACH * factor)]
        np.testing.assert_allclose(block.forces[np.isin(own, inner)], run[inner], rtol=0, atol=RIPPLE)
        np.testing.assert_array_equal(block.stresses[:, 0, 1], block.forces[:, 0])
        assert not block.forces.flags.writeable
    assert following >= len(run) > following - factor
    assert {block.speed for block in found} == set(speeds)


def test_blocks_are_the_same_for_any_cut():
    run = np.random.default_rng(3).normal(size=(3000, 2))
    speeds = np.where(np.arange(3000) < 1234, 20.0, 21.0)
    forces = []
    for lengths in ([3000], [7] * 400, [1389, 1389]):
        blocks = decimated((block for block, _ in cut(run, speeds, lengths)), 9)
        forces.append(np.concatenate([block.forces for block in blocks]))
    assert np.array_equal(forces[0], forces[1])
    assert np.array_equal(forces[0], forces[2])


def test_full_rate_is_the_run_itself(make_block):
    block = make_block(5, 100)
    assert [*decimated([block], 1)] == [block]


def test_a_gap_is_refused_and_a_new_run_is_not(make_block):
    thin = BlockDecimator(10)
    thin.push(make_block(0, 100))
    with pytest.raises(ValueError, match="step 101 does not follow step 99"):
        thin.push(make_block(101, 100))
    thin.finish()
    thin.push(make_block(7, 600))
    assert thin.finish()[-1].first_step <= 600
    assert BlockDecimator(10).finish() == []


@pytest.mark.parametrize("factor", [0, -1, 1001])
def test_factor_out_of_range(factor, make_block):
    with pytest.raises(InputError, match=f"factor = {factor} is out of range"):
        next(decimated([make_block(0, 10)], factor))


def test_state_does_not_grow(make_block):
    thin, whole = BlockDecimator(50), make_block(0, 20_000)
    sizes = []
    for start in range(0, 20_000, 100):
        part = slice(start, start + 100)
        thin.push(
            dataclasses.replace(
                whole, first_step=start, forces=whole.forces[part].copy(), stresses=whole.stresses[part].copy()
            )
        )
        sizes.append((len(thin._spans), thin._filter._sums.size))
    assert max(sizes) == sizes[len(sizes) // 2]


def test_signals_do_not_depend_on_each_other(make_block):
    whole = make_block(0, 3000)
    forces_alone = dataclasses.replace(whole, stresses=whole.stresses[:, :0], nodes=())
    with_zeros = dataclasses.replace(whole, stresses=np.zeros_like(whole.stresses))
    for other in (forces_alone, with_zeros):
        for block, expected in zip(decimated([other], 12), decimated([whole], 12), strict=True):
            np.testing.assert_array_equal(block.forces, expected.forces)
            assert block.stresses.shape == (len(expected), len(other.nodes), 6)
            assert not block.stresses.any()
