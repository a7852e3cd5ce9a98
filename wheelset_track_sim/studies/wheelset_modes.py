"""Fig. 12: the modes of the wheelset near 206 Hz and 1920 Hz, those that its axle's stress answers to most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from numpy.typing import NDArray

from ..errors import InputError
from ..report.figures import COLOURS, new_figure
from ..runtime.arrays import Real
from ..runtime.progress import Progress, unreported
from ..scenario import Scenario
from ..wheelset.kinds import with_geometry
from ..wheelset.reduced import COMPONENTS, ReducedWheelset
from ..wheelset.reduction import ModeShapes, mode_shapes, reduced_wheelset
from ..wheelset.section_mesh import SectionMesh
from ..wheelset.wheelset import Wheelset
from . import drawing
from .wheelset_receptances import watched_node

Nodes = NDArray[np.int64]

NEAR = (206.0, 1920.0)
"""Frequencies of Fig. 12, Hz."""
WITHIN = 1.2
"""Ratio of frequencies within which a mode is near."""
LARGEST = 0.07
"""Largest displacement as it is drawn, m."""
AROUND = 96
"""Facets around a surface of revolution."""
AZIMUTH, ELEVATION = np.radians([52.0, 16.0])
"""Where it is seen from: from the running direction towards the left, and from above."""
COLOUR_MAP = colormaps["viridis"]
SIDES = np.array([[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]])
RIM = [0, 4, 1, 5, 2, 6, 3, 7]
"""Nodes of an element's sides, and all of them in order around it."""
KINDS = {0: "axisymmetric", 1: "bending of the axle"}


def draw(out: Path, scenario: Scenario, progress: Progress | None = None) -> list[Path]:
    """Write ``wheelset_modes`` into ``out``: both modes in space and in section.

    Raises InputError for models that cannot be used, for a wheelset without a mode near those of the figure, and for
    a folder that cannot be written.
    """
    wheelset, node = with_geometry(scenario.wheelset), watched_node(scenario)
    reduced = reduced_wheelset(wheelset, progress=progress)
    report = progress or unreported
    report("mode shapes", 0.0)
    mesh, found = mode_shapes(wheelset, max(NEAR) * WITHIN)
    modes = [decisive_mode(found, reduced, node, frequency) for frequency in NEAR]
    report("mode shapes", 0.5)
    paths = _figure(out, wheelset, mesh, modes, reduced, node)
    columns = {"y (m)": mesh.points[:, 0], "r (m)": mesh.points[:, 1]}
    for mode in modes:
        for component, part in enumerate(("u_r", "u_y", "u_theta")):
            columns[f"{part} at {mode.frequency:.2f} Hz n = {mode.n} (1)"] = mode.shape[:, component]
    report("mode shapes", 1.0)
    return [*paths, drawing.table(out, "wheelset_modes", columns)]


def decisive_mode(found: Sequence[ModeShapes], reduced: ReducedWheelset, node: str, near: float) -> Mode:
    """The mode near a frequency (Hz) that the axial stress at a node answers to most, at resonance, from wheel 1.

    Raises InputError if the wheelset has no mode near.
    """
    axial = reduced.stress_outputs[reduced.node(node), COMPONENTS.index("yy")]
    peak = np.abs(axial * reduced.inputs[:, 0] / reduced.poles.real)
    peak[np.abs(np.log(reduced.frequencies / near)) > np.log(WITHIN)] = 0.0
    if not peak.any():
        raise InputError(f"the wheelset has no mode within {WITHIN:g} times {near:g} Hz: Fig. 12 cannot be drawn")
    frequency = reduced.frequencies[peak.argmax()]
    # The modulus of the pole is the undamped frequency: it tells the mode among those of all harmonics.
    family = min(found, key=lambda modes: np.abs(modes.frequencies - frequency).min(initial=np.inf))
    shape = family.shapes[np.abs(family.frequencies - frequency).argmin()]
    return Mode(float(frequency), family.n, shape / np.linalg.norm(shape, axis=1).max())


def _figure(
    out: Path, wheelset: Wheelset, mesh: SectionMesh, modes: Sequence[Mode], reduced: ReducedWheelset, node: str
) -> list[Path]:
    title = f"Wheelset {wheelset.name}: the modes that decide the axial stress at {node}"
    made = (
        "Undamped modes of the finite elements in Fourier harmonics cos nθ, which both dynamics keep; drawn with a "
        f"largest displacement of {1e3 * LARGEST:g} mm. Right: section through both contacts; thin lines: "
        "at rest. Wheel 1 on the left."
    )
    with new_figure(6.8, title, made) as figure:
        rows = figure.subplots(len(modes), 2, width_ratios=(1, 1.25), squeeze=False)
        for (space, section), mode in zip(rows, modes, strict=True):
            draw_surface(space, mesh, mode)
            draw_section(section, mesh, mode)
            _mark(section, wheelset, reduced, node)
            kind = KINDS.get(mode.n, f"{mode.n} nodal diameters")
            space.set_title(f"{mode.frequency:.1f} Hz, harmonic n = {mode.n} ({kind})", fontsize=10.5, loc="left")
        bar = figure.colorbar(ScalarMappable(cmap=COLOUR_MAP), ax=rows[:, 1], shrink=0.6, aspect=30)
        bar.set_label("displacement / largest")
        return drawing.save(out, "wheelset_modes", figure)


def _mark(axes: Axes, wheelset: Wheelset, reduced: ReducedWheelset, node: str) -> None:
    """The contact forces, and the stress node on the top of the axle."""
    radius, colour = wheelset.wheel.rolling_radius, COLOURS[0]
    arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    for wheel, y in enumerate(wheelset.contact_positions, start=1):
        axes.annotate("", (y, -radius - 0.03), (y, -radius - 0.19), arrowprops=arrow)
        axes.annotate(f"$F_{wheel}$", (y + 0.05, -radius - 0.15), color=colour)
    _, y, z = reduced.node_positions[reduced.node(node)]
    axes.plot(y, z, "o", color=colour, markersize=4.5)
    axes.annotate(node, (y, z), xytext=(5, 6), textcoords="offset points", color=colour, weight="bold")
    axes.set_ylim(-radius - 0.22, radius + 0.12)


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
        colours = COLOUR_MAP(np.linalg.norm(u, axis=1)[mesh.elements].mean(axis=1))
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
    colours = np.asarray(COLOUR_MAP(size))
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
