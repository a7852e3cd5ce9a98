"""Words and numbers that tables of fatigue share."""

from __future__ import annotations

from ..fatigue.curve import Curve
from ..inputs.amounts import in_unit

LABELS = {"elementary": "elementary", "haibach": "Haibach", "original": "original", "curve": "second slope"}
"""Rules of Miner in tables."""
PER = 1e6
"""Distance for which damage is printed, m."""


def by_curve(curve: Curve) -> str:
    """What the star in a table means: the constants of the curve with their source."""
    return (
        f"* by the S-N curve {curve.name}: {in_unit(curve.limit, 'MPa', 'Pa')} at {curve.knee_cycles:g} cycles, slope "
        f"{curve.slope:g}, survival {curve.survival_probability:g}, mean stress {curve.mean_stress}\n"
        f"source: {curve.source}"
    )
