"""What the figures of the studies have in common: one look, curves over frequency; files of figures and tables."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import InputError
from ..report.figures import COLOURS, PICTURES, finish
from ..runtime.arrays import Complex, Real
from ..runtime.output_files import file_name
from ..scenario import Scenario

BAND = 2500.0
"""Hz; the band of the paper, if the scenario gives none."""
BESIDE = 1.3
"""Ratio of frequencies below which a peak's label begins at the peak: it stands clear of that of the peak before."""


@dataclass(frozen=True)
class Look:
    """Name, colour and dashes of a curve."""

    name: str
    colour: str = COLOURS[0]
    dashes: Any = "-"
    width: float = 1.2


def save(out: Path, name: str, figure: Figure) -> list[Path]:
    """Write a figure as PNG, SVG and PDF into ``out``; raises InputError if they cannot be written."""
    paths = [out / f"{file_name(name)}{suffix}" for suffix in PICTURES]
    try:
        out.mkdir(parents=True, exist_ok=True)
        for path in paths:
            figure.savefig(path, metadata=PICTURES[path.suffix])
            figure.set_layout_engine("none")  # the layout is made: all files have the same
    except OSError as reason:
        raise unwritable(out, reason) from None
    return paths


def parquet(out: Path, name: str, columns: Mapping[str, Sequence[Any] | Real]) -> Path:
    """Write ``name.parquet`` into ``out``: the same columns with all digits. Needs pandas and pyarrow."""
    import pandas

    path = out / f"{file_name(name)}.parquet"
    try:
        pandas.DataFrame(dict(columns)).to_parquet(path, engine="pyarrow")
    except OSError as reason:
        raise unwritable(out, reason) from None
    return path


def table(out: Path, name: str, columns: Mapping[str, Sequence[Any] | Real]) -> Path:
    """Write ``name.csv`` into ``out``: one column each, headed by quantity and unit; numbers with seven digits."""
    path = out / f"{file_name(name)}.csv"
    try:
        out.mkdir(parents=True, exist_ok=True)
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            for row in zip(*columns.values(), strict=True):
                writer.writerow([value if isinstance(value, str) else f"{value:.7g}" for value in row])
    except OSError as reason:
        raise unwritable(out, reason) from None
    return path


def unwritable(out: Path, reason: OSError) -> InputError:
    """Error of a folder that cannot be written."""
    return InputError(f"{out} cannot be written ({reason.strerror}): give another folder with --out")


def over_frequency(axes: Sequence[Axes], frequencies: Real, curves: Mapping[Look, Complex], quantity: str) -> None:
    """Magnitude (log) and phase of responses over frequency (log), on two axes one above the other."""
    magnitude, phase = axes
    # The first curve is drawn last and lies on top.
    for look, response in reversed(list(curves.items())):
        style = {"color": look.colour, "linestyle": look.dashes, "linewidth": look.width, "label": look.name}
        magnitude.loglog(frequencies, np.abs(response), **style)
        phase.semilogx(frequencies, unbroken(phase_degrees(response)), **style)
    for each in axes:
        each.grid(which="major", color="#e3e3e6", linewidth=0.6)
        each.set_xlim(frequencies[0], frequencies[-1])
        each.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    finish(magnitude, quantity)
    magnitude.set_xlabel("")
    phase.set_ylabel("phase (°)")
    phase.set_yticks([-270, -180, -90, 0, 90])
    phase.set_ylim(-285, 105)
    phase.set_xlabel("frequency (Hz)")


def phase_degrees(response: Complex) -> Real:
    """Phase in [-270°, 90°): neither 0 nor -180°, where lightly damped responses stay, is at its edge."""
    phase: Real = (np.angle(response, deg=True) + 270.0) % 360.0 - 270.0
    return phase


def unbroken(phase: Real) -> Real:
    """Phase in degrees with NaN in the place of jumps by a whole turn, so that no line is drawn across."""
    shown = phase.copy()
    shown[1:][np.abs(np.diff(phase)) > 180.0] = np.nan
    return shown


def resonant_frequencies(poles: Complex, low: float, high: float) -> Real:
    """Frequencies in Hz, even in their logarithm, and finer around the poles (rad/s), so that no peak is cut."""
    offsets = np.array([0, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4, 6, 8, 12, 20, 40])
    offsets = np.concatenate([-offsets[:0:-1], offsets])
    around = (poles.imag[:, None] - poles.real[:, None] * offsets) / (2 * np.pi)
    found = np.union1d(np.geomspace(low, high, 2000), around.ravel())
    return found[(found >= low) & (found <= high)]


def label_peaks(axes: Axes, frequencies: Real, values: Real, count: int) -> list[float]:
    """Write the frequency over the ``count`` highest peaks of a curve, and return them, in Hz, in order."""
    axes.set_ylim(top=5 * values.max())
    inner = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
    highest = np.sort(inner[np.argsort(values[inner])[-count:]])
    for before, index in zip([0, *highest[:-1]], highest, strict=True):
        axes.annotate(
            f"{frequencies[index]:.0f}\nHz",
            (frequencies[index], values[index]),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center" if frequencies[index] > BESIDE * frequencies[before] else "left",
            fontsize=8.5,
            linespacing=0.95,
        )
    return [float(frequency) for frequency in frequencies[highest]]


def band(scenario: Scenario) -> float:
    """Highest frequency that is shown and transformed, Hz."""
    return BAND if scenario.max_frequency is None else scenario.max_frequency
