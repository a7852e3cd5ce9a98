"""One mode of a solid of revolution as a picture: its surface in space, and its section."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..wheelset.section_mesh import SectionMesh

Nodes = NDArray[np.int64]

LARGEST = 0.07
"""Largest displacement as it is drawn, m."""
AROUND = 96
"""Facets around a surface of revolution."""
AZIMUTH, ELEVATION = np.radians([52.0, 16.0])
"""Where it is seen from: from the running direction towards the left, and from above."""
COLOURS = colormaps["viridis"]
SIDES = np.array([[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]])
RIM = [0, 4, 1, 5, 2, 6, 3, 7]
"""Nodes of an element's sides, and all of them in order around it."""


@dataclass(frozen=True, eq=False)
class Mode:
    """One mode: its frequency in Hz, its harmonic, and its shape (nodes, 3), largest displacement 1."""

    frequency: float
    n: int
    shape: Real
    """Amplitudes of u_r, u_y (cos n theta) and u_theta (sin n theta); the contact is at theta = 0."""

    def displacement(self, nodes: Nodes, theta: Real) -> Real:
        """Displacements (..., 3) along r, y and theta at nodes and angles that broadcast against each other."""
        along = np.cos(self.n * theta)
        u: Real = self.shape[nodes] * np.stack([along, along, np.sin(self.n * theta)], axis=-1)
        return u


def draw_section(axes: Axes, mesh: SectionMesh, mode: Mode) -> None:
    """Deformed elements at theta = 0 (below) and theta = pi (above) over the outline at rest: z over y."""
    for theta, up in ((0.0, -1.0), (np.pi, 1.0)):
        u = mode.displacement(np.arange(len(mesh.points)), np.array(theta))
        moved = (mesh.points + LARGEST * u[:, [1, 0]]) * [1.0, up]
        colours = COLOURS(np.linalg.norm(u, axis=1)[mesh.elements].mean(axis=1))
        elements = moved[mesh.elements[:, RIM]]
        axes.add_collection(PolyCollection(list(elements), facecolors=colours, edgecolors="face", linewidths=0.2))
        rest = (mesh.points * [1.0, up])[surface_sides(mesh)]
        axes.add_collection(LineCollection(list(rest), colors="#222222", linewidths=0.6))
    axes.set_aspect("equal")
    axes.set_xlabel("y (m)")
    axes.set_ylabel("z (m)")
    axes.autoscale_view()


def draw_surface(axes: Axes, mesh: SectionMesh, mode: Mode) -> None:
    """Deformed surface in space: facets painted from far to near, coloured by displacement and lit."""
    facets, size = _facets(mesh, mode)
    towards = np.array([np.cos(AZIMUTH) * np.cos(ELEVATION), np.sin(AZIMUTH) * np.cos(ELEVATION), np.sin(ELEVATION)])
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    above = np.cross(towards, right)

    normal = np.cross(facets[:, 2] - facets[:, 0], facets[:, 3] - facets[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-12
    lamp = towards + 0.6 * above
    colours = np.asarray(COLOURS(size))
    colours[:, :3] *= 0.55 + 0.45 * np.abs(normal @ lamp / np.linalg.norm(lamp))[:, None]

    order = np.argsort(facets.mean(axis=1) @ towards)
    seen = np.stack([facets @ right, facets @ above], axis=-1)[order]
    # As points, not as lines: tens of thousands of facets would make a vector file of many megabytes.
    axes.add_collection(
        PolyCollection(list(seen), facecolors=colours[order], edgecolors="face", linewidths=0.3, rasterized=True)
    )
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")


def surface_sides(mesh: SectionMesh) -> Nodes:
    """Element sides (count, 3 nodes) on the surface: those that belong to one element only, without the axis."""
    sides = mesh.elements[:, SIDES].reshape(-1, 3)
    _, index, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    single = sides[index[count == 1]]
    surface: Nodes = single[(mesh.points[single, 1] > 0).any(axis=1)]
    return surface


def _facets(mesh: SectionMesh, mode: Mode) -> tuple[Real, Real]:
    """Corners (facets, 4, 3) in x, y, z of the deformed surface, and the mean displacement (facets,) of each."""
    sides = surface_sides(mesh)
    halves = np.concatenate([sides[:, :2], sides[:, 1:]])[..., None]
    theta = np.linspace(0.0, 2 * np.pi, AROUND + 1)
    u = mode.displacement(halves, theta)
    radial, axial, turning = np.moveaxis(LARGEST * u, -1, 0)
    y, r = mesh.points[halves, 0] + axial, mesh.points[halves, 1] + radial
    # theta = 0 points down, and theta runs towards +x.
    x = r * np.sin(theta) + turning * np.cos(theta)
    z = -r * np.cos(theta) + turning * np.sin(theta)
    corners = _corners(np.stack([x, y, z], axis=-1)).reshape(-1, 4, 3)
    return corners, _corners(np.linalg.norm(u, axis=-1)).reshape(-1, 4).mean(axis=1)


def _corners(values: Real) -> Real:
    """Values (sides, angles, 4, ...) at the corners of the facets, from those (sides, 2, angles + 1, ...) at nodes."""
    first, second = values[:, 0], values[:, 1]
    return np.stack([first[:, :-1], second[:, :-1], second[:, 1:], first[:, 1:]], axis=2)
