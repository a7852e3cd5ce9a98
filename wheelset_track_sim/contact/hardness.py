"""What steel bears: how much of a contact force is on elements above its hardness."""

from __future__ import annotations

import math

from ..runtime.arrays import Real

STEEL = 2.6e9
"""Hardness that pressures are compared with where a scenario states none, Pa.

A new rail of grade R260 has 260 to 300 HBW (EN 13674-1), and 260 HBW are 260 kgf/mm^2 = 2.55 GPa. Wheels of ER7 are
softer when new, from 235 HBW on (EN 13262); both harden under load.
"""


def share_from(pressures: Real, least: float) -> float:
    """Share of the force of ``pressures`` (nx, ny), Pa, on elements with the pressure ``least``, Pa, and more."""
    total = pressures.sum()
    return float(pressures[pressures >= least].sum() / total) if total > 0 else 0.0


def stated(bound: float) -> float:
    """The hardness that pressures with an upper ``bound``, Pa, are compared with: the bound, or that of steel."""
    return bound if bound < math.inf else STEEL


def flag(pressures: Real, bound: float = math.inf) -> str:
    """Words for people on pressures at the hardness or above; empty if there are none.

    ``pressures`` are (nx, ny), Pa; ``bound`` is the largest that the contact admits, Pa.
    """
    hardness = stated(bound)
    share = share_from(pressures, hardness)
    if share == 0.0:
        return ""
    part = f"{100 * share:.0f} %" if share >= 0.01 else "less than 1 %"
    return (
        f"pressure {'at the bound of' if bound < math.inf else 'above'} {hardness / 1e9:g} GPa on {part} of the force"
    )
