"""Hertz's point contact of two surfaces with principal curvatures along x and y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import elliprd, elliprf


@dataclass(frozen=True)
class HertzContact:
    """Elliptic contact with separation x^2/(2 Rx) + y^2/(2 Ry) and combined modulus E*.

    Semi-axes, approach and force follow from the potential of the pressure p0 sqrt(1 - (x/a)^2 - (y/b)^2) in
    Carlson's symmetric integrals: approach = (p0 a b/E*) R_F(0, a^2, b^2) and 1/(2 Rx) = (p0 a b/(3 E*))
    R_D(0, b^2, a^2) (K. L. Johnson, Contact Mechanics (1985), Section 4.2).
    """

    radius_x: float
    """Relative radius of curvature in the plane of x, m."""
    radius_y: float
    """Relative radius of curvature in the plane of y, m."""
    modulus: float
    """E*, Pa."""

    @property
    def axis_ratio(self) -> float:
        """b/a, lateral over longitudinal semi-axis; the same at every force."""
        low, high = -7.0, 7.0  # of its logarithm, halved up to rounding: importing scipy.optimize takes far longer
        for _ in range(56):
            middle = (low + high) / 2
            k2 = np.exp(2 * middle)
            if elliprd(0, 1, k2) * self.radius_y > elliprd(0, k2, 1) * self.radius_x:
                low = middle
            else:
                high = middle
        return float(np.exp((low + high) / 2))

    def semi_axes(self, force: float) -> tuple[float, float]:
        """Longitudinal and lateral semi-axis, m, under ``force``, N."""
        k = self.axis_ratio
        a = (force * self.radius_x * elliprd(0, k**2, 1) / (np.pi * self.modulus)) ** (1 / 3)
        return float(a), float(k * a)

    def peak_pressure(self, force: float) -> float:
        """Pressure in the middle of the contact, Pa."""
        a, b = self.semi_axes(force)
        return 1.5 * force / (np.pi * a * b)

    def approach(self, force: float) -> float:
        """Approach of the bodies, m, under ``force``, N."""
        if force == 0.0:
            return 0.0
        a, b = self.semi_axes(force)
        return float(1.5 * force / (np.pi * self.modulus) * elliprf(0, a**2, b**2))

    def force(self, approach: float) -> float:
        """Contact force, N, at ``approach``, m; zero without contact."""
        return float((max(approach, 0.0) / self.approach(1.0)) ** 1.5)
