"""The upper half of a wheelset's section for drawing: outlines of its parts, and its stress nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..runtime.arrays import Real
from .imported import ImportedWheelset
from .mesh import section_blocks
from .reduced import ReducedWheelset
from .wheelset import Wheelset


@dataclass(frozen=True, eq=False)
class SectionOutline:
    """Closed outlines in the half plane of y and r; mirrored at r = 0 they are the section."""

    parts: dict[str, list[Real]]
    """By part (axle, gearbox, wheel_1, wheel_2, equipment by name) outlines (points, 2) of y and r, m, the first point
    repeated at the end. A wheel has several: hub, web, rim, flange, brake discs. Empty for an imported wheelset."""
    masses: dict[str, Real]
    """Point masses: first and last y, and their radius, (3,) m."""
    contacts: Real
    """(2, 2): y and r of the nominal contact points."""
    node_names: tuple[str, ...]
    node_positions: Real
    """(nodes, 3): x, y, z of the stress nodes from the middle of the axle, m."""


def section_outline(wheelset: Wheelset | ImportedWheelset, reduced: ReducedWheelset) -> SectionOutline:
    """Outline of a wheelset; ``reduced`` is its model, which knows where stress nodes in fillets are."""
    parts: dict[str, list[Real]] = {}
    masses: dict[str, Real] = {}
    if isinstance(wheelset, ImportedWheelset):
        y = np.array(wheelset.contacts)
    else:
        y = np.array(wheelset.contact_positions)
        parts = {name: [_around(block) for block in blocks] for name, blocks in section_blocks(wheelset).items()}
        for item in wheelset.masses:
            radius = wheelset.axle.section_over(*item.ends, item.name).diameter / 2
            masses[item.name] = np.array([*item.ends, radius])
    contacts = np.stack([y, np.full(2, wheelset.rolling_radius)], axis=1)
    return SectionOutline(parts, masses, contacts, reduced.node_names, reduced.node_positions)


def _around(block: Real) -> Real:
    """Outline (points, 2) of a grid of points (n, m, 2), once around."""
    sides = block[:, 0], block[-1, 1:], block[-2::-1, -1], block[0, -2::-1]
    return np.concatenate(sides)
