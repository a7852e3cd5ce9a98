"""Figs 3 to 5: receptances and Green's functions at the wheels' contacts, and the stress response of the axle."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..dynamics.green_functions import frequency_grid, green_function
from ..errors import InputError
from ..report.figures import COLOURS, finish, new_figure
from ..runtime.arrays import Complex, Real
from ..runtime.progress import Progress, unreported
from ..scenario import Scenario
from ..wheelset.kinds import with_geometry
from ..wheelset.reduced import COMPONENTS, ReducedWheelset
from ..wheelset.reduction import reduced_wheelset
from ..wheelset.wheelset import Wheelset
from . import drawing
from .drawing import Look

LOWEST = 1.0
"""Hz; well below the bounce on the suspension."""
PERIOD = 50.0
"""Length of the Green's functions, s (Fig. 4): with little damping they ring for long."""
SHOWN, CLOSE = 1.0, 0.008
"""What of them is drawn, s: as in Fig. 4, and closer."""
BLOCK = 5000
AXIAL = COMPONENTS.index("yy")

WHEEL_1 = Look("direct, wheel 1", COLOURS[0])
WHEEL_2 = Look("direct, wheel 2 (next to the gearbox)", "#222222", (0, (5, 2)), 1.0)
CROSS = Look("from one wheel to the other (cross)", COLOURS[1])


def draw(out: Path, scenario: Scenario, progress: Progress | None = None) -> list[Path]:
    """Write ``wheelset_receptances``, ``wheelset_green_functions`` and ``axle_stress_response`` into ``out``.

    Raises InputError for models that cannot be used, for a scenario without stress nodes, and for a folder that
    cannot be written.
    """
    wheelset = with_geometry(scenario.wheelset)
    reduced = reduced_wheelset(wheelset, progress=progress)
    report = progress or unreported
    frequencies = drawing.resonant_frequencies(reduced.poles, LOWEST, drawing.band(scenario))
    report("wheelset figures", 0.1)
    paths = _receptances(out, wheelset, reduced, frequencies)
    report("wheelset figures", 0.3)
    paths += _stress(out, wheelset, reduced, frequencies, watched_node(scenario))
    report("wheelset figures", 0.5)
    paths += _green_functions(out, wheelset, reduced, scenario)
    report("wheelset figures", 1.0)
    return paths


def watched_node(scenario: Scenario) -> str:
    """First stress node of the scenario's output, A1 unless it says otherwise; raises InputError if it has none."""
    if not scenario.output.stress_nodes:
        raise InputError("output.stress_nodes is empty: name the stress node to draw, such as A1")
    return scenario.output.stress_nodes[0]


def made_by(reduced: ReducedWheelset) -> str:
    """The model that made the curves."""
    highest = reduced.frequencies.max() / 1e3
    return (
        f"Finite elements in Fourier harmonics, reduced to {len(reduced.poles)} complex poles up to {highest:.1f} kHz"
    )


def _receptances(out: Path, wheelset: Wheelset, reduced: ReducedWheelset, frequencies: Real) -> list[Path]:
    receptance = reduced.receptance(frequencies)
    curves = {WHEEL_1: receptance[:, 0, 0], WHEEL_2: receptance[:, 1, 1], CROSS: receptance[:, 1, 0]}
    title = f"Wheelset {wheelset.name}: receptances at the wheel–rail contacts"
    made = f"{made_by(reduced)}. Both dynamics use it. Static: {_static(reduced)}."
    with new_figure(6.4, title, made) as figure:
        axes = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        drawing.over_frequency(axes, frequencies, curves, "receptance (m/N)")
        paths = drawing.save(out, "wheelset_receptances", figure)
    # The statics stand in the table, where a logarithmic axis cannot show them.
    static = reduced.static_receptance()
    columns: dict[str, Real] = {"frequency (Hz)": np.concatenate([[0.0], frequencies])}
    for name, at, load in (("direct wheel 1", 0, 0), ("direct wheel 2", 1, 1), ("cross", 1, 0)):
        curve = np.concatenate([[static[at, load]], receptance[:, at, load]])
        columns |= _polar(name, curve, "m/N")
    return [*paths, drawing.table(out, "wheelset_receptances", columns)]


def _stress(out: Path, wheelset: Wheelset, reduced: ReducedWheelset, frequencies: Real, node: str) -> list[Path]:
    index = reduced.node(node)
    response = reduced.stress_receptance(frequencies)[:, index, AXIAL]
    curves = {Look("load on wheel 1", COLOURS[0]): response[:, 0], Look("load on wheel 2", COLOURS[1]): response[:, 1]}
    title = f"Wheelset {wheelset.name}: axial stress σyy at {node} (top of the axle) over the contact force"
    static = reduced.static_stress()[index, AXIAL]
    made = (
        f"{made_by(reduced)}, with static residual; used by both dynamics. "
        f"Static: {static[0]:.0f} and {static[1]:.0f} Pa/N."
    )
    with new_figure(6.4, title, made) as figure:
        axes = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        drawing.over_frequency(axes, frequencies, curves, "stress over force (Pa/N)")
        drawing.label_peaks(axes[0], frequencies, np.abs(response).max(axis=1), 5)
        paths = drawing.save(out, "axle_stress_response", figure)
    columns: dict[str, Real] = {"frequency (Hz)": np.concatenate([[0.0], frequencies])}
    for wheel in range(2):
        curve = np.concatenate([[static[wheel]], response[:, wheel]])
        columns |= _polar(f"sigma_yy {node} load on wheel {wheel + 1}", curve, "Pa/N")
    return [*paths, drawing.table(out, "axle_stress_response", columns)]


def _green_functions(out: Path, wheelset: Wheelset, reduced: ReducedWheelset, scenario: Scenario) -> list[Path]:
    limit, dt = drawing.band(scenario), scenario.step_period
    time: Real = np.arange(round(SHOWN / dt) + 1, dtype=np.float64) * dt
    printed, modal = band_limited(reduced, limit, dt)[:, : len(time)], impulse_response(reduced, time)
    title = f"Wheelset {wheelset.name}: Green's functions at the wheel–rail contacts"
    made = (
        f"Paper dynamics: inverse Fourier transform of the receptance up to {limit:g} Hz, Eq. (1), with a period of "
        f"{PERIOD:g} s. Its first value (dot) is what the band limit makes of the rise at t = 0; the coupled step of "
        "the paper sets it to zero. Causal dynamics: sum of the modes, without a band limit of its own. "
        f"{made_by(reduced)}."
    )
    with new_figure(6.6, title, made) as figure:
        whole, close = figure.subplots(2, 1)
        early = time <= CLOSE
        for row, look in ((1, CROSS), (0, WHEEL_1)):
            whole.plot(time, 1e6 * printed[row], color=look.colour, linewidth=0.9, label=f"{look.name}, paper")
            close.plot(1e3 * time[early], 1e6 * printed[row, early], color=look.colour, linewidth=1.8)
            close.plot(0, 1e6 * printed[row, 0], color=look.colour, marker="o", clip_on=False)
            name = "causal (direct and cross)" if row else ""
            close.plot(1e3 * time[early], 1e6 * modal[row, early], color="#222222", linewidth=0.8, label=name)
        for axes, unit, end in ((whole, "s", SHOWN), (close, "ms", 1e3 * CLOSE)):
            axes.axhline(0, color="#c8c8cc", linewidth=0.6, zorder=0)
            finish(axes, "Green's function (µm/(N s))")
            axes.set_xlabel(f"time ({unit})")
            axes.set_xlim(0, end)
        paths = drawing.save(out, "wheelset_green_functions", figure)
    columns = {"time (s)": time}
    for name, values in (("band-limited", printed), ("modal", modal)):
        columns |= {f"{name} direct wheel 1 (m/(N s))": values[0], f"{name} cross (m/(N s))": values[1]}
    return [*paths, drawing.table(out, "wheelset_green_functions", columns)]


def band_limited(reduced: ReducedWheelset, max_frequency: float, dt: float) -> Real:
    """Green's functions (2, samples) in m/(N s) by Eq. (1) over one period: direct of wheel 1, and cross."""
    frequencies, samples = frequency_grid(max_frequency, PERIOD, dt)
    blocks = np.array_split(frequencies, max(1, len(frequencies) // BLOCK))
    receptance = np.concatenate([reduced.receptance(block)[:, :, 0] for block in blocks]).T
    return green_function(receptance, samples, dt)


def impulse_response(reduced: ReducedWheelset, time: Real) -> Real:
    """Displacements (2, times) in m/(N s) of wheels 1 and 2 at times (s) after a unit impulse on wheel 1."""
    residues = reduced.outputs * reduced.inputs[:, 0]
    blocks = np.array_split(time, max(1, len(time) // BLOCK))
    return np.concatenate([(residues @ np.exp(np.outer(reduced.poles, block))).real for block in blocks], axis=1)


def _static(reduced: ReducedWheelset) -> str:
    static = reduced.static_receptance() * 1e9
    return f"{static[0, 0]:.0f}, {static[1, 1]:.0f} and cross {static[1, 0]:.0f} nm/N"


def _polar(name: str, response: Complex, unit: str) -> dict[str, Real]:
    return {f"{name} magnitude ({unit})": np.abs(response), f"{name} phase (deg)": drawing.phase_degrees(response)}
