"""Lower triangular matrices whose leading blocks are used at any size: rows packed in panels of 16.

Row c holds its columns 0 to c and zeros up to the end of its panel, so that the 16 rows of a panel are equally long:
row c starts at ``row(c)`` and has ``width(c)`` entries. The leading block of n rows is the beginning of the array.
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
    """Sum of products, over the length of ``a``."""
    total = 0.0
    for t in range(len(a)):
        total += a[t] * b[t]
    return total


@summing_kernel
def dot_4(u: Vector, a: Vector, b: Vector, c: Vector, d: Vector) -> tuple[float, float, float, float]:
    """Sums of products of ``u`` with four others."""
    total_a, total_b, total_c, total_d = 0.0, 0.0, 0.0, 0.0
    for t in range(len(u)):
        total_a += u[t] * a[t]
        total_b += u[t] * b[t]
        total_c += u[t] * c[t]
        total_d += u[t] * d[t]
    return total_a, total_b, total_c, total_d


@summing_kernel
def add_scaled(target: Vector, factor: float, source: Vector) -> None:
    """Add ``factor`` times ``source`` to ``target``, over the length of ``target``."""
    for t in range(len(target)):
        target[t] += factor * source[t]


@summing_kernel
def clear(target: Vector) -> None:
    """Set to zero.

    Here and elsewhere, part of an array is a slice: a loop that begins within an array runs at a fifth of the pace, for
    the compiler must expect indices that count from its end.
    """
    for t in range(len(target)):
        target[t] = 0.0


@block_kernel
def multiply(rows: Vector, first: int, end: int, b: Vector, product: Vector) -> None:
    """Fill ``product[first:end]`` with those rows of the matrix times ``b``; four at a time, ``first`` in fours."""
    for c in range(first, end, 4):
        w, at = width(c), row(c)
        product[c], product[c + 1], product[c + 2], product[c + 3] = dot_4(
            b[:w], rows[at:], rows[at + w :], rows[at + 2 * w :], rows[at + 3 * w :]
        )


@block_kernel
def multiply_transposed(rows: Vector, end: int, b: Vector, low: int, high: int, product: Vector) -> None:
    """Fill ``product[low:high]``, in whole panels, with the transposed leading block of ``end`` rows times ``b``."""
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
    """Cholesky factor L, K = L L^T, in panels; NaN if K (n, n) is not positive definite. n in whole panels."""
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
    """Inverse of the leading block of ``n`` rows, in whole panels, of a triangular matrix in panels."""
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
