"""Section mesh of a wheelset: axle with fillets, wheels, brake discs and gearbox as conforming blocks.

Every block is a product of nodes along y and nodes along r. An attached part takes the nodes of what carries it, so
blocks conform by construction and parts are tied at their contact surfaces, as in the paper (Section 3).
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

import numpy as np

from ..runtime.arrays import Real
from .parts import BrakeDiscs, Step, Wheel
from .section_mesh import RESOLUTION, SectionMesh, between, divided, grid, joined, with_middles
from .stress_node import StressNode
from .wheelset import MeshSize, Wheelset

GRADING = 2.0
"""Exponent by which axle elements get thinner towards the surface, where the stress is wanted."""

TRANSITION = 0.015
"""Length of the element that leads from a fillet into the cylinder, m."""


def wheelset_mesh(wheelset: Wheelset, size: MeshSize | None = None) -> SectionMesh:
    """Mesh of a wheelset; ``size`` replaces the wheelset's own."""
    return joined([block for blocks in section_blocks(wheelset, size).values() for block in blocks])


def axle_mesh(wheelset: Wheelset, size: MeshSize | None = None) -> SectionMesh:
    """Mesh of the axle alone: the nodes it has in that of the wheelset."""
    return joined(section_blocks(wheelset, size)["axle"])


def section_blocks(wheelset: Wheelset, size: MeshSize | None = None) -> dict[str, list[Real]]:
    """Blocks of each part, grids (2 n + 1, 2 m + 1, 2) of y and r: axle, gearbox, wheel_1, wheel_2, rings by name."""
    size = size or wheelset.mesh
    y = _axle_nodes(wheelset, size)
    surface = surface_radius(wheelset, y)
    bore = wheelset.axle.bore / 2
    layers = ceil((surface.max() - bore) / size.radial)
    depth = with_middles(1.0 - (1.0 - np.arange(layers + 1) / layers) ** GRADING)
    parts = {"axle": [grid(y[:, None], bore + (surface[:, None] - bore) * depth[None, :])]}

    def ring(ends: tuple[float, float], outer_radius: float) -> list[Real]:
        seat = between(y, *ends)
        inner_radius = surface_radius(wheelset, seat)[0]
        return [grid(seat[:, None], divided([inner_radius, outer_radius], size.attached)[None, :])]

    if wheelset.gearbox:
        parts["gearbox"] = ring(wheelset.gearbox_ends, wheelset.gearbox.outer_radius)
    for name, side in (("wheel_1", -1), ("wheel_2", 1)):
        low, high = sorted((side * wheelset.wheel.hub_inner, side * wheelset.wheel.hub_outer))
        seat = between(y, low, high)
        inner_radius = surface_radius(wheelset, seat)[0]
        # A wheel is meshed at positive distances from the track's centre, then put on its side.
        wheel = _wheel_blocks(wheelset.wheel, wheelset.brake_discs, np.sort(side * seat), inner_radius, size)
        parts[name] = [block[::side] * np.array([side, 1.0]) for block in wheel]
    return parts | {item.name: ring(item.ends, item.outer_radius) for item in wheelset.rings}


def fillet_points(step: Step, size: float) -> Real:
    """Nodes (count, 2) on the arc of a fillet in order of y: even in angle, so that all lie on the arc."""
    angle = divided([0.0, step.angle], size / step.fillet)
    y = step.tangent - step.direction * step.fillet * np.sin(angle)
    r = step.low + step.fillet * (1.0 - np.cos(angle))
    return np.stack([y, r], axis=1)[np.argsort(y)]


def stress_fillet(wheelset: Wheelset, node: StressNode, size: MeshSize | None = None) -> Real:
    """Mesh nodes (count, 2) on the fillet that a stress node is named after, in order of y."""
    step = next(step for step in wheelset.axle.steps() if step.after == node.after)
    return fillet_points(step, (size or wheelset.mesh).fillet)


def surface_radius(wheelset: Wheelset, y: Real) -> Real:
    """Radius of the axle's surface at y, m; the thicker section's at its edge."""
    ends = np.array([section.end for section in wheelset.axle.sections])
    radii = np.array([section.diameter / 2 for section in wheelset.axle.sections])
    r: Real = radii[np.searchsorted(ends[:-1], y)]
    for step in wheelset.axle.steps():
        low, high = sorted((step.edge, step.tangent))
        on = (y > low - RESOLUTION) & (y < high + RESOLUTION)
        rise = 1.0 - np.sqrt(np.clip(1.0 - ((y[on] - step.tangent) / step.fillet) ** 2, 0.0, None))
        r[on] = step.low + step.fillet * rise
    return r


def _axle_nodes(wheelset: Wheelset, size: MeshSize) -> Real:
    """Nodes of the axle along y: breaks wherever something starts or ends, fillets finer."""
    wheel, boxes = wheelset.wheel, wheelset.axle_boxes
    half = boxes.bearing_length / 2
    distances = [wheel.hub_inner, wheel.hub_outer, boxes.distance - half, boxes.distance + half]
    distances += [wheel.web - wheel.web_thickness_hub / 2, wheel.web + wheel.web_thickness_hub / 2]
    breaks = {wheelset.axle.start, *(section.end for section in wheelset.axle.sections)}
    breaks |= {side * distance for distance in distances for side in (-1, 1)}
    if wheelset.gearbox:
        breaks |= set(wheelset.gearbox_ends)
    for item in wheelset.equipment:
        breaks |= set(item.ends)
    fillets = wheelset.axle.steps()
    breaks |= {step.tangent for step in fillets}
    # A short element leads from the fillet into the cylinder, where the stress is still uneven.
    breaks |= {step.tangent + step.direction * TRANSITION for step in fillets}
    y = divided(_apart(sorted(breaks)), size.axle)
    for step in fillets:
        low, high = sorted((step.edge, step.tangent))
        watched = any(node.on(step) for node in wheelset.stress_nodes)
        arc = fillet_points(step, size.fillet if watched else size.axle / 2)[:, 0]
        y = np.concatenate([y[y < low - RESOLUTION], arc, y[y > high + RESOLUTION]])
    return y


def _apart(values: list[float]) -> list[float]:
    """Sorted values without those that repeat the one before."""
    return [value for index, value in enumerate(values) if index == 0 or value - values[index - 1] > RESOLUTION]


def _wheel_blocks(
    wheel: Wheel, discs: BrakeDiscs | None, seat: Real, inner_radius: float, size: MeshSize
) -> Iterator[Real]:
    """Blocks of a wheel on the positive side; ``seat`` are the axle's nodes under the hub."""
    yield grid(seat[:, None], divided([inner_radius, wheel.hub_radius], size.attached)[None, :])

    radii = [wheel.hub_radius, wheel.rim_radius]
    if discs:
        radii += [discs.inner_radius, discs.spacer_inner_radius, discs.spacer_outer_radius, discs.outer_radius]
    r = divided(sorted(radii), size.attached)
    half = np.array([wheel.web_half_thickness(radius) for radius in r])
    root = between(seat, wheel.web - half[0], wheel.web + half[0])
    across = (root - wheel.web) / half[0]
    yield grid(wheel.web + across[:, None] * half[None, :], r[None, :])
    if discs:
        yield from _disc_blocks(wheel, discs, r, size)

    web = wheel.web + across * half[-1]
    flange = wheel.rim_inner + wheel.flange_width
    inner = divided([wheel.rim_inner, flange, web[0]], size.attached)
    outer = divided([web[-1], wheel.rim_outer], size.attached)
    rim = np.concatenate([inner[:-1], web, outer[1:]])
    yield grid(rim[:, None], divided([wheel.rim_radius, wheel.rolling_radius], size.attached)[None, :])
    height = divided([0.0, wheel.flange_height], size.attached)
    taper = 1.0 - (1.0 - wheel.flange_top_width / wheel.flange_width) * height / wheel.flange_height
    base = between(rim, wheel.rim_inner, flange) - wheel.rim_inner
    yield grid(wheel.rim_inner + base[:, None] * taper[None, :], (wheel.rolling_radius + height)[None, :])


def _disc_blocks(wheel: Wheel, discs: BrakeDiscs, r: Real, size: MeshSize) -> Iterator[Real]:
    """Spacers and plane discs on both sides of the web, with the web's nodes along r."""
    disc = between(r, discs.inner_radius, discs.outer_radius)
    spacer = between(r, discs.spacer_inner_radius, discs.spacer_outer_radius)
    web = np.array([wheel.web_half_thickness(radius) for radius in spacer])
    face = wheel.web_half_thickness((spacer[0] + spacer[-1]) / 2) + discs.spacer_thickness
    thickness = divided([face, face + discs.thickness], size.attached)
    part = divided([0.0, 1.0], size.attached / discs.spacer_thickness)
    offset = web[None, :] + part[:, None] * (face - web[None, :])
    yield grid(wheel.web + offset, spacer[None, :])
    yield grid(wheel.web - offset[::-1], spacer[None, :])
    yield grid(wheel.web + thickness[:, None], disc[None, :])
    yield grid(wheel.web - thickness[::-1, None], disc[None, :])
