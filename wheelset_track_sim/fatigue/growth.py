"""Crack growth: how far a crack grows in a cycle, with the source of the constants and their scatter.

With the stress ratio R = K_min / K_max of a cycle of the stress intensity K, and a reference range K_r, Paris' law is::

    da/dN = rate (DK_open / K_r)^exponent          DK_open = K_max - max(K_min, 0)

below which nothing grows up to the threshold max(threshold - threshold_slope max(R, 0), least_threshold).

The NASGRO equation adds crack closure by Newman's function f(R), the approach to the threshold and to fracture::

    da/dN = rate ((1 - f) DK / ((1 - R) K_r))^exponent (1 - DK_th / DK)^p / (1 - K_max / toughness)^q
    DK_th = threshold sqrt(a / (a + a_0)) ((1 - A_0) (1 - R) / (1 - f))^(1 + C_th R)

Sources: P. Paris, F. Erdogan, A critical analysis of crack propagation laws, J. Basic Eng. 85 (1963) 528-533; J.C.
Newman, A crack opening stress equation for fatigue crack growth, Int. J. Fracture 24 (1984) R131-R135; NASGRO reference
manual, JSC-22267B, NASA, 2001.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, quantity, read
from ..runtime.arrays import Real
from .curve import ASSUMED

LAWS = {"paris": "law of Paris", "nasgro": "NASGRO equation"}
"""As people read them."""
ENDS = {"slow": -1, "middle": 0, "fast": 1}
"""Ends of the band over the scatter of the inputs, and its middle."""
LEAST_RATIO = -2.0
"""Least stress ratio for which Newman's function is known."""


@dataclass(frozen=True)
class CrackGrowth:
    """Growth of a surface crack of an axle: law, constants, shape of the crack, and the scatter of each. SI units.

    Examples
    --------
    >>> growth = load_crack_growth("assumed_steel")
    >>> f"{growth.rate_of(10e6, 0.0, 0.002):.3g} m a cycle at 10 MPa sqrt(m), {growth.at('fast').rate / growth.rate:g}"
    '1.65e-08 m a cycle at 10 MPa sqrt(m), 2'
    """

    name: str
    source: str
    """Where the constants come from; begins with ``assumed`` if they are an assumption."""
    law: Literal["paris", "nasgro"]
    rate: float = quantity("m", 1e-16, 1e-3, "the growth in a cycle of the reference range")
    reference_range: float = quantity("Pa sqrtm", 1e3, 1e9, "the reference range of the stress intensity")
    exponent: float = quantity("", 1.0, 20.0, "the exponent of the law")
    threshold: float = quantity("Pa sqrtm", 0.0, 5e7, "the threshold of the range at R = 0")
    toughness: float = quantity("Pa sqrtm", 1e6, 1e9, "the stress intensity of fracture")
    rate_factor: float = quantity("", 1.0, 1e3, "the factor from the middle rate to either end of its scatter")
    threshold_factor: float = quantity(
        "", 1.0, 10.0, "the factor from the middle threshold to either end of its scatter"
    )
    aspect: float = quantity("", 0.0, 1.0, "the ratio of depth to semi-axis along the surface")
    aspect_scatter: float = quantity("", 0.0, 0.5, "how far either end of the aspect is from the middle", default=0.0)
    residual_stress: float = quantity("Pa", -1e9, 1e9, "the residual stress at the surface", default=0.0)
    residual_stress_scatter: float = quantity("Pa", 0.0, 1e9, "how far either end is from the middle", default=0.0)
    threshold_slope: float = quantity("Pa sqrtm", 0.0, 5e7, "the fall of the threshold over R", default=0.0)
    least_threshold: float = quantity("Pa sqrtm", 0.0, 5e7, "the least threshold", default=0.0)
    p: float = quantity("", 0.0, 5.0, "p of NASGRO", default=0.0)
    q: float = quantity("", 0.0, 5.0, "q of NASGRO", default=0.0)
    constraint: float = quantity("", 1.0, 3.0, "the constraint factor alpha of NASGRO", default=2.5)
    stress_over_flow: float = quantity(
        "", 0.0, 0.9, "the ratio of the largest to the flow stress of NASGRO", default=0.3
    )
    threshold_exponent: float = quantity("", -5.0, 5.0, "C_th of NASGRO for R >= 0", default=0.0)
    negative_threshold_exponent: float = quantity("", -5.0, 5.0, "C_th of NASGRO for R < 0", default=0.0)
    intrinsic_length: float = quantity("m", 0.0, 1e-3, "the intrinsic crack length a_0 of NASGRO", default=38.1e-6)

    def __post_init__(self) -> None:
        check(self)
        if not self.source.strip():
            raise InputError("source is empty: say where the constants come from, or write 'assumed' and why")
        if not 0.0 <= self.aspect - self.aspect_scatter <= self.aspect + self.aspect_scatter <= 1.0 + 1e-12:
            raise InputError(
                f"aspect = {self.aspect:g} with aspect_scatter = {self.aspect_scatter:g} leaves 0 to 1: give less"
            )

    @property
    def assumed(self) -> bool:
        """Whether the constants are an assumption by their own source."""
        return self.source.lower().startswith(ASSUMED)

    @property
    def note(self) -> str:
        """Law and source, as people read them beside numbers that depend on them."""
        return f"{LAWS[self.law]} {self.name}; source: {self.source}"

    def at(self, end: str) -> CrackGrowth:
        """Growth at an end of the scatter of all inputs together: ``slow``, ``middle`` or ``fast``."""
        sign = ENDS[end]
        return dataclasses.replace(
            self,
            rate=self.rate * self.rate_factor**sign,
            threshold=self.threshold / self.threshold_factor**sign,
            threshold_slope=self.threshold_slope / self.threshold_factor**sign,
            least_threshold=self.least_threshold / self.threshold_factor**sign,
            aspect=min(max(self.aspect - sign * self.aspect_scatter, 0.0), 1.0),
            residual_stress=self.residual_stress + sign * self.residual_stress_scatter,
            rate_factor=1.0,
            threshold_factor=1.0,
            aspect_scatter=0.0,
            residual_stress_scatter=0.0,
        )

    def rate_of(self, largest: Real | float, ratio: Real | float, depth: Real | float) -> Real:
        """Growth in a cycle, m.

        Parameters
        ----------
        largest
            Largest stress intensity of the cycle, Pa sqrt(m); nothing grows where it is not above 0.
        ratio
            Of the least to the largest stress intensity.
        depth
            Of the crack, m.
        """
        largest, ratio = np.maximum(largest, 0.0), np.asarray(ratio, dtype=np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            found = (self._paris if self.law == "paris" else self._nasgro)(largest, ratio, depth)
        rate: Real = np.where(largest > 0.0, found, 0.0)
        return rate

    def _paris(self, largest: Real, ratio: Real, depth: Real | float) -> Real:
        positive = np.maximum(ratio, 0.0)
        open_range = largest * (1.0 - positive)
        threshold = np.maximum(self.threshold - self.threshold_slope * positive, self.least_threshold)
        grown: Real = self.rate * (open_range / self.reference_range) ** self.exponent
        return np.where(open_range > threshold, grown, 0.0)

    def _nasgro(self, largest: Real, ratio: Real, depth: Real | float) -> Real:
        ratio = np.maximum(ratio, LEAST_RATIO)
        opening = self.opening(ratio)
        effective, full = (1.0 - opening) * largest, (1.0 - ratio) * largest
        exponent = 1.0 + np.where(ratio < 0.0, self.negative_threshold_exponent, self.threshold_exponent) * ratio
        closure = (1.0 - self._constants[0]) * (1.0 - ratio) / (1.0 - opening)
        threshold = self.threshold * np.sqrt(depth / (depth + self.intrinsic_length)) * closure**exponent
        above, below = np.maximum(1.0 - threshold / full, 0.0), np.maximum(1.0 - largest / self.toughness, 0.0)
        grown = self.rate * (effective / self.reference_range) ** self.exponent * above**self.p / below**self.q
        found: Real = np.where(full > threshold, grown, 0.0)
        return found

    def opening(self, ratio: Real | float) -> Real:
        """Newman's function f: the ratio of the stress intensity at which the crack opens to the largest one."""
        ratio = np.asarray(ratio, dtype=np.float64)
        first, second, third, fourth = self._constants
        positive = np.maximum(ratio, first + ratio * (second + ratio * (third + ratio * fourth)))
        found: Real = np.where(ratio < 0.0, first + second * ratio, positive)
        return found

    @property
    def _constants(self) -> tuple[float, float, float, float]:
        """A_0 to A_3 of Newman's function."""
        alpha, share = self.constraint, self.stress_over_flow
        first = (0.825 - 0.34 * alpha + 0.05 * alpha**2) * math.cos(math.pi / 2 * share) ** (1.0 / alpha)
        second = (0.415 - 0.071 * alpha) * share
        fourth = 2.0 * first + second - 1.0
        return first, second, 1.0 - first - second - fourth, fourth


def load_crack_growth(source: str | Path) -> CrackGrowth:
    """Load the growth of a crack.

    Parameters
    ----------
    source
        Name of a shipped file (``assumed_steel``), or path of a YAML file.

    Returns
    -------
    CrackGrowth
        Law, constants and scatter, with their source.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used, or without a source.
    """
    return read(CrackGrowth, shipped.load_yaml("cracks", source), "")
