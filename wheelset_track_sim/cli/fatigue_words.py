"""Words and numbers that tables of fatigue share."""

from __future__ import annotations

from ..fatigue.curve import Curve

LABELS = {"elementary": "elementary", "haibach": "Haibach", "original": "original", "curve": "second slope"}
"""Rules of Miner in tables."""
PER = 1e6
"""Distance for which damage is printed, m."""


def by_curve(curve: Curve) -> str:
    """What the star in a table means: the constants of the curve with their source."""
    return f"* by the {curve.note}"
