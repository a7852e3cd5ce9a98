"""Fig. 12: the modes of the wheelset near 206 Hz and 1920 Hz, those that its axle's stress answers to most."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from ..errors import InputError
from ..report.figures import COLOURS, new_figure
from ..runtime.progress import Progress
from ..scenario import Scenario
from ..wheelset.kinds import with_geometry
from ..wheelset.reduced import COMPONENTS, ReducedWheelset
from ..wheelset.reduction import ModeShapes, mode_shapes, reduced_wheelset
from ..wheelset.section_mesh import SectionMesh
from ..wheelset.wheelset import Wheelset
from . import drawing, mode_drawing
from .mode_drawing import Mode
from .wheelset_receptances import watched_node

NEAR = (206.0, 1920.0)
"""Frequencies of Fig. 12, Hz."""
WITHIN = 1.2
"""Ratio of frequencies within which a mode is near."""
KINDS = {0: "axisymmetric", 1: "bending of the axle"}


def draw(out: Path, scenario: Scenario, progress: Progress | None = None) -> list[Path]:
    """Write ``wheelset_modes`` into ``out``: both modes in space and in section.

    Raises InputError for models that cannot be used, for a wheelset without a mode near those of the figure, and for
    a folder that cannot be written.
    """
    wheelset, node = with_geometry(scenario.wheelset), watched_node(scenario)
    reduced = reduced_wheelset(wheelset, progress=progress)
    report = progress or (lambda stage, fraction: None)
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
        f"largest displacement of {1e3 * mode_drawing.LARGEST:g} mm. Right: section through both contacts; thin lines: "
        "at rest. Wheel 1 on the left."
    )
    with new_figure(6.8, title, made) as figure:
        rows = figure.subplots(len(modes), 2, width_ratios=(1, 1.25), squeeze=False)
        for (space, section), mode in zip(rows, modes, strict=True):
            mode_drawing.draw_surface(space, mesh, mode)
            mode_drawing.draw_section(section, mesh, mode)
            _mark(section, wheelset, reduced, node)
            kind = KINDS.get(mode.n, f"{mode.n} nodal diameters")
            space.set_title(f"{mode.frequency:.1f} Hz, harmonic n = {mode.n} ({kind})", fontsize=10.5, loc="left")
        bar = figure.colorbar(ScalarMappable(cmap=mode_drawing.COLOURS), ax=rows[:, 1], shrink=0.6, aspect=30)
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
