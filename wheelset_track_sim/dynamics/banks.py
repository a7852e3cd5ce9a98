"""Modes in banks, as ``causal_kernels`` wants them in memory."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import Complex, Real
from .causal_kernels import ROW

REGISTER = 8
"""Numbers in the widest vector register; banks begin on the border of one and are filled in whole ones."""


def whole_registers(modes: int) -> int:
    """Number of modes rounded up to whole vector registers."""
    return -(-modes // REGISTER) * REGISTER


def padded(values: Complex, axis: int, length: int) -> Complex:
    """``values`` with zeros behind them up to ``length`` along an ``axis``."""
    widths = [(0, 0)] * values.ndim
    widths[axis] = (0, length - values.shape[axis])
    return np.pad(values, widths)


def banked(rows: Complex) -> Real:
    """Rows of modes, (..., K, modes), as banks of real and imaginary parts: (..., banks, 2 K ROW), aligned memory."""
    banks = -(-rows.shape[-1] // ROW)
    split = padded(rows, -1, banks * ROW).reshape(*rows.shape[:-1], banks, ROW)
    parts = np.stack([split.real, split.imag], axis=-3)  # (..., K, 2, banks, ROW)
    parts = np.moveaxis(parts, -2, -4)
    return aligned(parts).reshape(*rows.shape[:-2], banks, 2 * rows.shape[-2] * ROW)


def aligned(values: Real) -> Real:
    """Copy of ``values`` whose memory begins on the border of a vector register."""
    memory = np.zeros(values.size + REGISTER)
    first = -memory.ctypes.data // memory.itemsize % REGISTER
    copied = memory[first : first + values.size].reshape(values.shape)
    copied[...] = values
    return copied


def unbanked(banks: Real, modes: int) -> Complex:
    """First of the rows that ``banked`` has laid out as (banks, 2 K ROW): (modes,)."""
    values: Complex = (banks[:, :ROW] + 1j * banks[:, ROW : 2 * ROW]).ravel()[:modes]
    return values
