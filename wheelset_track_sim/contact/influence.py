"""Influence coefficients of rectangular elements on two elastic half-spaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..runtime.arrays import Real


def contact_modulus(youngs_modulus: float, poissons_ratio: float) -> float:
    """E* of two bodies of one material, Pa: 1/E* = 2 (1 - nu^2)/E."""
    return youngs_modulus / (2.0 * (1.0 - poissons_ratio**2))


def influence(x: ArrayLike, y: ArrayLike, dx: float, dy: float, youngs_modulus: float, poissons_ratio: float) -> Real:
    """Displacement difference at (x, y) due to unit pressure on the element dx x dy at the origin, m/Pa.

    This is A of Eq. (10): the Boussinesq solution integrated over a rectangle (A. E. H. Love, Phil. Trans. R. Soc. A
    228 (1929) 377-420; J. J. Kalker, Three-dimensional elastic bodies in rolling contact (1990), App. C), for two
    bodies of the same material. (x, y) must not lie on a line through an edge of the element.
    """
    total = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))
    for side in (0.5, -0.5):
        for end in (0.5, -0.5):
            X = np.asarray(x, float) + side * dx
            Y = np.asarray(y, float) + end * dy
            total += 4 * side * end * (X * np.arcsinh(Y / np.abs(X)) + Y * np.arcsinh(X / np.abs(Y)))
    return total / (np.pi * contact_modulus(youngs_modulus, poissons_ratio))


def influence_table(nx: int, ny: int, dx: float, dy: float, youngs_modulus: float, poissons_ratio: float) -> Real:
    """Influence coefficients by element offset |i - I| and |j - J|, (nx, ny), m/Pa."""
    return influence(np.arange(nx)[:, None] * dx, np.arange(ny) * dy, dx, dy, youngs_modulus, poissons_ratio)
