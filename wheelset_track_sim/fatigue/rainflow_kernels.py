"""Rainflow counting of a stream, sample by sample, with bounded memory.

Turning points. The extreme e since the last turning point moves on with the signal. It becomes a turning point when the
signal x has come back from it by more than the gate g::

    |e - x| > g

so ranges up to the gate are merged into the larger ones around them, and those that stay have their exact extremes.
With g = 0 every reversal is a turning point.

Four-point rule. Of the last four turning points a, b, c, d the inner range is a cycle, and b and c are removed, if::

    |c - b| <= |b - a|   and   |c - b| <= |d - c|

What remains is the residue: ranges that grow, then shrink. It counts as half cycles, which makes the count equal to
that of the three-point rule of ASTM E1049-85, 5.4.4.

Bounded memory. Ranges that grow or shrink slowly make a residue of any length. If the memory for it is full, its first
range is counted as a half cycle and its first point is removed, as ASTM E1049 does with a range that contains the
starting point. So no range is lost; ``FORCED`` counts how often it happens.

Source: ASTM E1049-85 (2017), Standard Practices for Cycle Counting in Fatigue Analysis, 5.4.4; four-point rule: C.
Amzallag, J.P. Gerey, J.L. Robert, J. Bahuaud, Standardization of the rainflow counting method for fatigue analysis,
International Journal of Fatigue 16 (1994) 287-293.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import kernel

CAPACITY = 128
"""Turning points of the residue of a channel."""
RANGES, RANGE_WIDTH = 128, 5e6
"""Rows of the range-mean matrix, and their width, Pa; the last one holds all larger ranges, too."""
MEANS, MEAN_WIDTH = 64, 10e6
"""Columns of the matrix about a mean of 0, and their width, Pa; the outer ones hold all means beyond, too."""
LEVELS, LEVEL_WIDTH = 256, 5e6
"""Levels about 0 whose crossings are counted, and their distance, Pa."""

PREVIOUS, EXTREME, OTHER = range(3)
"""Last sample; extreme since the last turning point; before the first turning point, the other extreme. Pa."""
SIGN, DIRECTION, DEPTH, REVERSALS, TURNING, FORCED, STARTED = range(7)
"""Sense of the last change; sense towards the extreme (0 before the first turning point: then ``SIGN`` of the later
extreme is in ``LATER``); points of the residue; reversals of the signal; turning points; forced half cycles; begun."""
LATER = 7
STRESSES, COUNTS = 3, 8


class Channels(NamedTuple):
    """State of C channels with Q rules of damage: all that a count needs to go on."""

    stresses: Real
    """(C, STRESSES), Pa."""
    counts: NDArray[np.int64]
    """(C, COUNTS)."""
    residue: Real
    """(C, CAPACITY), Pa; the first ``DEPTH`` are turning points."""
    matrix: NDArray[np.int64]
    """(C, RANGES, MEANS) half cycles."""
    sums: Real
    """(C, RANGES, 2) sums of range and of mean over the half cycles of a row of the matrix, Pa."""
    crossings: NDArray[np.int64]
    """(C, LEVELS + 1): upward crossings of a level less those of the level before."""
    damage: Real
    """(C, Q)."""


@kernel
def count(state: Channels, channel: int, stress: Real, gate: float, sensitivity: float, rules: Real) -> None:
    """Count further samples of a channel.

    Parameters
    ----------
    state
        Changed in place.
    channel
        Row of the state.
    stress
        (n,) Pa.
    gate
        Ranges up to it are merged, Pa.
    sensitivity
        To mean stress: see ``equivalent_amplitude``.
    rules
        (Q, 4) of ``damage_of``.
    """
    stresses, counts = state.stresses[channel], state.counts[channel]
    if not len(stress):
        return
    if counts[STARTED] == 0:
        counts[STARTED] = 1
        stresses[:] = stress[0]
    previous, extreme = stresses[PREVIOUS], stresses[EXTREME]
    sign, direction = counts[SIGN], counts[DIRECTION]
    for x in stress:
        if x != previous:
            now = 1 if x > previous else -1
            if now == -sign:
                counts[REVERSALS] += 1
            sign, previous = now, x
        if direction > 0:
            if x >= extreme:
                extreme = x
            elif extreme - x > gate:
                turn(state, channel, extreme, sensitivity, rules)
                direction, extreme = -1, x
        elif direction < 0:
            if x <= extreme:
                extreme = x
            elif x - extreme > gate:
                turn(state, channel, extreme, sensitivity, rules)
                direction, extreme = 1, x
        else:  # extreme is the highest so far, OTHER the lowest
            if x > extreme:
                extreme, counts[LATER] = x, 1
            elif x < stresses[OTHER]:
                stresses[OTHER], counts[LATER] = x, -1
            if extreme - stresses[OTHER] > gate:
                direction = counts[LATER]
                first, last = (stresses[OTHER], extreme) if direction > 0 else (extreme, stresses[OTHER])
                turn(state, channel, first, sensitivity, rules)
                extreme = last
    stresses[PREVIOUS], stresses[EXTREME] = previous, extreme
    counts[SIGN], counts[DIRECTION] = sign, direction


@kernel
def turn(state: Channels, channel: int, point: float, sensitivity: float, rules: Real) -> None:
    """Add a turning point to the residue, and take cycles that it closes from there."""
    counts, residue = state.counts[channel], state.residue[channel]
    depth = counts[DEPTH]
    if depth:
        cross(state.crossings[channel], residue[depth - 1], point)
    if depth == len(residue):
        tally(state, channel, residue[0], residue[1], 1, sensitivity, rules)
        residue[:-1] = residue[1:].copy()
        depth -= 1
        counts[FORCED] += 1
    residue[depth] = point
    depth += 1
    counts[TURNING] += 1
    while depth >= 4:
        inner = abs(residue[depth - 2] - residue[depth - 3])
        if inner > abs(residue[depth - 3] - residue[depth - 4]) or inner > abs(point - residue[depth - 2]):
            break
        tally(state, channel, residue[depth - 3], residue[depth - 2], 2, sensitivity, rules)
        depth -= 2
        residue[depth - 1] = point
    counts[DEPTH] = depth


@kernel
def finish(state: Channels, sensitivity: float, rules: Real) -> None:
    """Count the residue of all channels as half cycles, with the extreme as its last point; the state ends there."""
    for channel in range(len(state.counts)):
        counts = state.counts[channel]
        if counts[DIRECTION]:
            turn(state, channel, state.stresses[channel, EXTREME], sensitivity, rules)
        for point in range(counts[DEPTH] - 1):
            low, high = state.residue[channel, point], state.residue[channel, point + 1]
            tally(state, channel, low, high, 1, sensitivity, rules)
        counts[DEPTH] = counts[DIRECTION] = counts[STARTED] = 0


@kernel
def tally(
    state: Channels, channel: int, start: float, end: float, halves: int, sensitivity: float, rules: Real
) -> None:
    """Add half cycles between two turning points to the matrix and the damage."""
    span, mean = abs(end - start), (start + end) / 2
    row = bin_of(span, RANGE_WIDTH, 0, RANGES - 1)
    state.matrix[channel, row, bin_of(mean, MEAN_WIDTH, MEANS // 2, MEANS - 1)] += halves
    state.sums[channel, row, 0] += halves * span
    state.sums[channel, row, 1] += halves * mean
    harm(state.damage[channel], start, end, halves, sensitivity, rules)


@kernel
def harm(damage: Real, start: float, end: float, halves: int, sensitivity: float, rules: Real) -> None:
    """Add the damage of half cycles between two turning points to ``damage`` (Q,)."""
    amplitude = equivalent_amplitude(abs(end - start) / 2, (start + end) / 2, sensitivity)
    for rule in range(len(rules)):
        damage[rule] += halves / 2 * damage_of(amplitude, rules[rule])


@kernel
def damage_so_far(state: Channels, sensitivity: float, rules: Real) -> Real:
    """Damage of all channels, (C, Q), with the residue as ``finish`` counts it, bit by bit; the state does not change.

    It costs a copy of the residues alone, not of the matrices.
    """
    damage = state.damage.copy()
    points = np.empty(CAPACITY)
    for channel in range(len(state.counts)):
        depth = state.counts[channel, DEPTH]
        points[:] = state.residue[channel]
        if state.counts[channel, DIRECTION]:
            last = state.stresses[channel, EXTREME]
            if depth == CAPACITY:
                harm(damage[channel], points[0], points[1], 1, sensitivity, rules)
                points[:-1] = points[1:].copy()
                depth -= 1
            points[depth] = last
            depth += 1
            while depth >= 4:
                inner = abs(points[depth - 2] - points[depth - 3])
                if inner > abs(points[depth - 3] - points[depth - 4]) or inner > abs(last - points[depth - 2]):
                    break
                harm(damage[channel], points[depth - 3], points[depth - 2], 2, sensitivity, rules)
                depth -= 2
                points[depth - 1] = last
        for point in range(depth - 1):
            harm(damage[channel], points[point], points[point + 1], 1, sensitivity, rules)
    return damage


@kernel
def cross(crossings: NDArray[np.int64], start: float, end: float) -> None:
    """Count the levels that the signal crosses upwards from one turning point to the next."""
    if end > start:
        crossings[bin_of(start, LEVEL_WIDTH, LEVELS // 2 + 1, LEVELS)] += 1
        crossings[bin_of(end, LEVEL_WIDTH, LEVELS // 2 + 1, LEVELS)] -= 1


@kernel
def bin_of(stress: float, width: float, zero: int, last: int) -> int:
    """Number of the bin of a stress, 0 to ``last``; ``zero`` is the one that begins at 0 Pa."""
    return int(min(max(np.floor(stress / width) + zero, 0.0), float(last)))


@kernel
def equivalent_amplitude(amplitude: float, mean: float, sensitivity: float) -> float:
    """Amplitude at mean stress 0, Pa, that damages as much as ``amplitude`` about ``mean`` does.

    With the mean stress sensitivity M, lines of equal damage fall over the mean with the slope 0 for stress ratios
    R > 1, M up to R = 0, and M / 3 beyond; they are continuous. M = 0 ignores the mean. Source: the Haigh diagram
    ``fkm_goodman`` of pylife 2.3, after the FKM guideline.
    """
    third = sensitivity / 3
    if mean < -amplitude:
        return amplitude * (1 - sensitivity)
    if mean <= amplitude:
        return amplitude + sensitivity * mean
    return (amplitude + third * mean) * (1 + sensitivity) / (1 + third)


@kernel
def damage_of(amplitude: float, rule: Real) -> float:
    """Damage of one cycle by Miner: 1 / N, with N = knee (limit / amplitude)^slope.

    ``rule`` has limit, Pa, knee, the slope above the limit and that below it; an infinite slope does no damage.
    """
    share = amplitude / rule[0]
    damage: float = share ** (rule[2] if share >= 1.0 else rule[3]) / rule[1]
    return damage
