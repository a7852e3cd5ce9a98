"""Fewer samples without aliasing: a linear-phase low pass at full rate, of which each ``factor``-th value is made.

Samples are kept at the steps that are whole multiples of the factor, wherever the run is cut into blocks. A kept sample
is the weighted mean of the ``2 * REACH * factor + 1`` steps around its own, so it carries the stamp of its own step
without delay, and is known ``REACH`` kept samples later. Relative to half the new sampling rate the filter passes all
below ``PASSBAND`` within ``RIPPLE``, and nothing above 1 by more than ``RIPPLE``, 80 dB down: a Kaiser window (J. F.
Kaiser, "Nonrecursive digital filter design using the I0-sinh window function", Proc. IEEE ISCAS (1974) 20-23).

The filter counts in steps, and a step is a length: a change of speed changes the band in Hz as it changes the sampling
rate itself, and needs no new filter. What is kept are the waves along the track that the new samples can tell apart, at
any speed. A peak that is narrower than the filter comes out lower, and a force beside an impact a little below zero:
the summary holds what happens at full rate.
"""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Iterable, Iterator
from functools import lru_cache

import numpy as np

from ..errors import InputError
from ..inputs.schema import Quantity
from ..runtime.arrays import Real
from .block import SampleBlock
from .decimation_kernels import accumulate

FACTOR = Quantity("", 1, 1000, "the number of steps from sample to sample")
PASSBAND = 0.8
"""End of the pass band, as a share of half the new sampling rate."""
RIPPLE = 1e-4
"""Bound on the error of the pass band and on what is left of the stop band: 80 dB."""
REACH = 26
"""Half the length of the filter in kept samples, which is what an output lags behind."""


@lru_cache(maxsize=8)
def low_pass(factor: int) -> Real:
    """Response (2 REACH factor + 1,) to one sample, symmetric about its middle, with the sum 1."""
    half = REACH * factor
    # Kaiser's formulas: attenuation by length and transition, window by attenuation.
    attenuation = 7.95 + 2.285 * 2 * half * (1.0 - PASSBAND) * math.pi / factor
    window = np.kaiser(2 * half + 1, 0.1102 * (attenuation - 8.7))
    response: Real = window * np.sinc((1.0 + PASSBAND) / 2 / factor * np.arange(-half, half + 1))
    response /= response.sum()
    response.flags.writeable = False
    return response


@lru_cache(maxsize=8)
def polyphase(factor: int) -> Real:
    """``low_pass`` by the phase of a step between kept samples, and by the sample it adds to: (factor, 2 REACH + 1)."""
    padded = np.concatenate([low_pass(factor), np.zeros(factor - 1)])
    weights: Real = np.ascontiguousarray(padded.reshape(2 * REACH + 1, factor).T[:, ::-1])
    weights.flags.writeable = False
    return weights


class Decimator:
    """Signals in, each ``factor``-th sample out; any cut of the same run gives the same bits.

    Before the first and behind the last step the signals are taken to stay as they are there, so a constant comes out
    from the first sample to the last.
    """

    def __init__(self, factor: int, first_step: int) -> None:
        """For a run that begins at ``first_step``."""
        self._factor, self._weights, self._half = factor, polyphase(factor), REACH * factor
        self._step = first_step
        self._last: Real | None = None
        self._number = -(-first_step // factor)  # of the first output that is not complete
        self._sums = np.zeros((0, 0))  # (signals, outputs begun)

    @property
    def next_step(self) -> int:
        """Step of the next sample that comes out."""
        return self._number * self._factor

    def push(self, samples: Real) -> Real:
        """Samples (n, signals) of the next steps in; those that are complete out, from ``next_step`` before on."""
        if self._last is None:
            self._sums = np.zeros((samples.shape[1], 0))
            self._step -= self._half
            self._add(np.repeat(samples[:1].T, self._half, axis=1))
        self._last = samples[-1:].T.copy()
        return self._add(np.ascontiguousarray(samples.T))

    def finish(self) -> Real:
        """The samples up to the last step that went in; the decimator is used up."""
        if self._last is None:
            return np.zeros((0, 0))
        return self._add(np.repeat(self._last, self._half, axis=1))

    def _add(self, samples: Real) -> Real:
        """Samples (signals, n) in, those that are complete (outputs, signals) out."""
        end = self._step + samples.shape[1]
        latest = (end - 1) // self._factor
        sums = np.zeros((len(samples), max(0, latest + REACH + 1 - self._number)))
        sums[:, : self._sums.shape[1]] = self._sums
        accumulate(sums, self._number, self._step, self._weights, samples)
        complete = max(0, latest - REACH + 1 - self._number)
        self._step, self._number, self._sums = end, self._number + complete, sums[:, complete:]
        return sums[:, :complete].T


class BlockDecimator:
    """A stream of blocks in, gap-free blocks of each ``factor``-th sample out, ``REACH`` of these later.

    Each block that comes out is at one speed and of one revision, those in force at its samples' own steps.
    """

    def __init__(self, factor: int) -> None:
        self.factor = factor
        self._filter: Decimator | None = None
        self._spans: deque[tuple[SampleBlock, int]] = deque()  # a block, without samples, and the end of what it is for

    def push(self, block: SampleBlock) -> list[SampleBlock]:
        """What is complete with ``block``, which follows the last one; ValueError if it does not."""
        if self.factor == 1:
            return [block]
        if self._filter is None:
            self._filter = Decimator(self.factor, block.first_step)
        elif block.first_step != self._spans[-1][1]:
            raise ValueError(f"step {block.first_step} does not follow step {self._spans[-1][1] - 1}")
        self._remember(block)
        first = self._filter.next_step
        stresses = np.moveaxis(block.stresses, 0, -1).reshape(-1, len(block))
        return self._labelled(first, self._filter.push(np.concatenate([block.forces.T, stresses]).T))

    def finish(self) -> list[SampleBlock]:
        """What is left up to the last step; the next block may begin anywhere."""
        if self._filter is None:
            return []
        rest = self._labelled(self._filter.next_step, self._filter.finish())
        self._filter = None
        self._spans.clear()
        return rest

    def _remember(self, block: SampleBlock) -> None:
        end = block.first_step + len(block)
        if self._spans:
            before, _ = self._spans[-1]
            if _at(before) == _at(block):
                self._spans[-1] = before, end
                return
        self._spans.append((dataclasses.replace(block, forces=block.forces[:0], stresses=block.stresses[:0]), end))

    def _labelled(self, first: int, samples: Real) -> list[SampleBlock]:
        found = []
        while len(samples):
            span, end = self._spans[0]
            count = min(len(samples), len(range(first, end, self.factor)))
            if count:
                found.append(_block(span, first, samples[:count], self.factor))
            first, samples = first + count * self.factor, samples[count:]
            if len(samples):
                self._spans.popleft()
        return found


def decimated(blocks: Iterable[SampleBlock], factor: int) -> Iterator[SampleBlock]:
    """Each ``factor``-th sample of a full-rate run, low-pass filtered; InputError for a factor out of range."""
    refusal = FACTOR.refusal("factor", factor)
    if refusal:
        raise InputError(refusal)
    thin = BlockDecimator(factor)
    for block in blocks:
        yield from thin.push(block)
    yield from thin.finish()


def _at(block: SampleBlock) -> tuple[float, float, int]:
    return block.step_period, block.speed, block.revision


def _block(span: SampleBlock, step: int, samples: Real, factor: int) -> SampleBlock:
    since = (step - span.first_step) * span.step_period
    return dataclasses.replace(
        span,
        first_step=step,
        time=span.time + since,
        step_period=factor * span.step_period,
        position=span.position + since * span.speed,
        forces=samples[:, :2].copy(),
        sensors={},
        stresses=np.moveaxis(samples.T[2:].reshape(*span.stresses.shape[1:], len(samples)).copy(), -1, 0),
        decimation=factor,
    )
