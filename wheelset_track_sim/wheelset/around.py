"""Stress of static loads around the axle: what is there at an angle, and what a point goes through that turns.

Loads that are the same around the axle (press fit, torque) and loads that bend it make stresses of harmonics 0 and 1::

    sigma(a) = mean + cosine cos(a) + sine sin(a)

``a`` is the angle from the top in the sense in which the wheels turn, as that of a stress node: pi / 2 is the front.
Components are in axes that turn with it: r outwards, y to the left, t backwards at the top and forwards at the bottom.
Bending in the vertical plane is ``cosine`` in rr, yy, tt and ry, and its shear ``sine`` in rt and yt; bending in the
horizontal plane has both the other way round. So a point that turns sees ``cosine`` and ``sine`` in quadrature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..runtime.arrays import Real
from .stress_points import in_axes

POLAR = ("rr", "yy", "tt", "ry", "rt", "yt")
"""Order of stress components in axes that turn with the angle; the last two change sign with the sense of ``a``."""
NEARLY_NONE = 0.1
"""Cosine or sine of an angle below which the stress there does not determine an amplitude."""
SHEAR = np.array([False, False, False, False, True, True])


@dataclass(frozen=True, eq=False)
class Around:
    """Stress at N places along the axle by angle, Pa, or Pa for a unit of a load."""

    mean: Real
    """(N, 6) in the order ``POLAR``."""
    cosine: Real
    """(N, 6)."""
    sine: Real
    """(N, 6)."""

    @classmethod
    def even(cls, amplitudes: Real) -> Around:
        """Of amplitudes (N, 6) of harmonic 0."""
        return cls(amplitudes, np.zeros_like(amplitudes), np.zeros_like(amplitudes))

    @classmethod
    def vertical(cls, amplitudes: Real) -> Around:
        """Of amplitudes (N, 6) of harmonic 1 with fields symmetric about the bottom, theta = 0: a = pi - theta."""
        return cls(np.zeros_like(amplitudes), np.where(SHEAR, 0.0, -amplitudes), np.where(SHEAR, amplitudes, 0.0))

    @classmethod
    def horizontal(cls, amplitudes: Real) -> Around:
        """Of amplitudes (N, 6) of harmonic 1 with fields antisymmetric about the bottom."""
        return cls(np.zeros_like(amplitudes), np.where(SHEAR, amplitudes, 0.0), np.where(SHEAR, 0.0, amplitudes))

    @classmethod
    def none(cls, places: int) -> Around:
        """No stress at a number of places."""
        return cls.even(np.zeros((places, 6)))

    @classmethod
    def of_points(cls, stresses: Real, angles: Real) -> Around:
        """The same all around as at ``angles`` (N,), where it is ``stresses`` (N, 6) in x, y, z."""
        turned = [np.linalg.solve(in_axes(a, 1.0, 1.0), stress) for a, stress in zip(angles, stresses, strict=True)]
        return cls.even(np.array(turned).reshape(-1, 6))

    @classmethod
    def vertical_of_points(cls, stresses: Real, angles: Real) -> Around:
        """Of bending in the vertical plane that makes ``stresses`` (N, 6) in x, y, z at ``angles`` (N,).

        One angle has bending or shear: on the top and the bottom the shear of the sides is not known and taken as none,
        and likewise at the front and the rear the bending of the top.
        """
        given = cls.of_points(stresses, angles).mean
        cosine, sine = (
            np.divide(given, part, out=np.zeros_like(given), where=np.abs(part) > NEARLY_NONE)
            for part in (np.cos(angles)[:, None], np.sin(angles)[:, None])
        )
        return cls(np.zeros_like(given), np.where(SHEAR, 0.0, cosine), np.where(SHEAR, sine, 0.0))

    def __add__(self, other: Around) -> Around:
        """Both loads together."""
        return Around(self.mean + other.mean, self.cosine + other.cosine, self.sine + other.sine)

    def chosen(self, places: list[int]) -> Around:
        """Some of the places."""
        return Around(self.mean[places], self.cosine[places], self.sine[places])

    def polar(self, angles: Real) -> Real:
        """Stress in axes that turn with the angle: what a point of the axle goes through in a turn.

        Parameters
        ----------
        angles
            (A,) from the top, rad.

        Returns
        -------
        Real
            (N, 6, A) Pa in the order ``POLAR``.
        """
        a = np.asarray(angles, dtype=np.float64)
        return self.mean[..., None] + self.cosine[..., None] * np.cos(a) + self.sine[..., None] * np.sin(a)

    def at(self, angles: Real) -> Real:
        """Stress in the axes of the track at one angle for each place: what a stress node shows.

        Parameters
        ----------
        angles
            (N,) from the top, rad.

        Returns
        -------
        Real
            (N, 6) Pa: xx, yy, zz, xy, xz, yz.
        """
        found = np.zeros_like(self.mean)
        for place, a in enumerate(angles):
            found[place] = in_axes(float(a), 1.0, 1.0) @ self.polar(np.array([a]))[place, :, 0]
        return found


def angles_of(positions: Real) -> Real:
    """Angles (N,), rad, from the top of places (N, 3) on the axle's surface."""
    angles: Real = np.arctan2(positions[:, 0], positions[:, 2])
    return angles
