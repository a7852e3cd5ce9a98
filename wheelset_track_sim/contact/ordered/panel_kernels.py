"""Lower triangular matrices whose leading blocks are used at any size: rows packed in panels of 16.

Row c holds its columns 0 to c, then zeros up to the end of its panel. So the 16 rows of panel P = c // 16 have the same
length 16 (P + 1), ``width(c)``. The panels before it hold 16^2 (1 + 2 + ... + P) = 128 P (P + 1) entries, so row c
starts at ``row(c)`` = 128 P (P + 1) + 16 (P + 1) (c mod 16). The leading block of n rows is the first ``row(n)``
entries.

Products take four rows at a time: each entry of the vector is then loaded once for four multiply-adds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import block_kernel, inner_kernel, summing_kernel

Vector = NDArray[np.float64]

PANEL = 16
"""Rows in a panel: sums over whole panels need no remainder in vector registers."""


@inner_kernel
def row(c: int) -> int:
    """Where row ``c`` starts."""
    panel = c >> 4
    return (128 * panel + 16 * (c & 15)) * (panel + 1)


@inner_kernel
def width(c: int) -> int:
    """Length of row ``c``: ``c + 1`` rounded up to whole panels."""
    return (c | 15) + 1


@summing_kernel
def dot(a: Vector, b: Vector) -> float:
    """Sum of products over the length of ``a``."""
    total = 0.0
    for t in range(len(a)):
        total += a[t] * b[t]
    return total


@summing_kernel
def dot_4(u: Vector, a: Vector, b: Vector, c: Vector, d: Vector) -> tuple[float, float, float, float]:
    """Sums of products of ``u`` with four other vectors, over the length of ``u``."""
    total_a, total_b, total_c, total_d = 0.0, 0.0, 0.0, 0.0
    for t in range(len(u)):
        total_a += u[t] * a[t]
        total_b += u[t] * b[t]
        total_c += u[t] * c[t]
        total_d += u[t] * d[t]
    return total_a, total_b, total_c, total_d


@summing_kernel
def add_scaled(target: Vector, factor: float, source: Vector) -> None:
    """Add ``factor`` times ``source`` to ``target`` over the length of ``target``."""
    for t in range(len(target)):
        target[t] += factor * source[t]


@summing_kernel
def clear(target: Vector) -> None:
    """Set all entries to zero.

    Pass a slice to clear part of an array. A loop that begins within an array runs at a fifth of the pace, because the
    compiler must allow for negative indices. The other kernels of this folder take slices for the same reason.
    """
    for t in range(len(target)):
        target[t] = 0.0


@block_kernel
def multiply(rows: Vector, first: int, end: int, b: Vector, product: Vector) -> None:
    """Multiply rows of a triangular matrix by a vector.

    Parameters
    ----------
    rows
        Matrix in panels.
    first, end
        First row, a multiple of 4, and the one after the last. Up to three rows beyond it are multiplied as well.
    b
        Vector, as long as the widest of these rows.
    product
        ``product[first:end]`` is filled.
    """
    for c in range(first, end, 4):
        w, at = width(c), row(c)
        product[c], product[c + 1], product[c + 2], product[c + 3] = dot_4(
            b[:w], rows[at:], rows[at + w :], rows[at + 2 * w :], rows[at + 3 * w :]
        )


@block_kernel
def multiply_transposed(rows: Vector, end: int, b: Vector, low: int, high: int, product: Vector) -> None:
    """Multiply the transpose of the leading block by a vector.

    Parameters
    ----------
    rows
        Matrix in panels.
    end
        Rows of the block, a multiple of 4.
    b
        Vector, (end,).
    low, high
        Part of the product that is wanted, in whole panels.
    product
        ``product[low:high]`` is filled.
    """
    clear(product[low:high])
    for c in range(low, end, 4):
        w, at = width(c), row(c) + low
        target = product[low : min(w, high)]
        one, two, three, four = rows[at:], rows[at + w :], rows[at + 2 * w :], rows[at + 3 * w :]
        b1, b2, b3, b4 = b[c], b[c + 1], b[c + 2], b[c + 3]
        for t in range(len(target)):
            target[t] += b1 * one[t] + b2 * two[t] + b3 * three[t] + b4 * four[t]


@block_kernel
def factored(K: Real) -> Vector:
    """Cholesky factor L of K = L L^T, in panels; K is (n, n), with n in whole panels.

    Row by row, L_ct = (K_ct - sum_i<t L_ti L_ci) / L_tt. Entries are NaN if K is not positive definite.
    """
    n = len(K)
    L = np.zeros(row(n))
    for c in range(n):
        own = L[row(c) : row(c) + width(c)]
        for t in range(c):
            other = L[row(t) : row(t) + t]
            own[t] = (K[c, t] - dot(other, own)) / L[row(t) + t]
        own[c] = np.sqrt(K[c, c] - dot(own[:c], own))
    return L


@block_kernel
def inverted(L: Vector, n: int) -> Vector:
    """Inverse X of the leading block of ``n`` rows of L, in whole panels, in panels.

    Row by row, X_c = (e_c - sum_t<c L_ct X_t) / L_cc from L X = 1.
    """
    X = np.zeros(row(n))
    for c in range(n):
        at = row(c)
        own = X[at : at + c + 1]
        for t in range(c):
            factor, other = L[at + t], X[row(t) : row(t) + t + 1]
            for i in range(len(other)):
                own[i] -= factor * other[i]
        own[c] = 1.0
        for t in range(c + 1):
            own[t] /= L[at + c]
    return X
