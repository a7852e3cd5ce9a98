"""Picture of an identification: data, fit and band of each observation; of a peak, the sizes that make it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from ..identification.kinds import KINDS
from ..identification.observation import Signal
from ..identification.results import LEAST, Band, Identification, KindFit
from .figures import COLOURS, new_figure, write_picture

SIZES: dict[Signal, tuple[str, float]] = {
    "force": ("contact force (kN)", 1e3),
    "box": ("axle box acceleration (g)", 9.81),
}
BAND = 1.645
"""Standard deviations of a 90 % band."""


def draw_identification(found: Identification, path: Path) -> Path:
    """Draw what explains the data; returns ``path``. Raises InputError if it cannot be written."""
    bands, fits = found.best.bands, [fit for fit in found.kinds if fit.draws.size and fit.probability >= LEAST]
    rows = len(bands) or max(1, len(fits))
    made_by = f"identify on {found.scenario.wheelset.name} and {found.scenario.track.name}"
    with new_figure(1.2 + 2.4 * rows, _title(found), made_by) as figure:
        axes = figure.subplots(rows, 1, squeeze=False)[:, 0]
        for axis, band in zip(axes, bands, strict=False):
            _draw_band(axis, band)
        if not bands:
            for axis, fit in zip(axes, fits, strict=False):
                _draw_sizes(axis, fit)
        return write_picture(figure, path)


def _title(found: Identification) -> str:
    best = found.best
    sizes = ", ".join(
        f"{each.meaning} {1e3 * found_size.estimate:.3g} mm"
        if each.unit
        else f"{each.meaning} {found_size.estimate:.3g}"
        for each in (KINDS[best.kind].unknowns if best.kind in KINDS else ())
        for found_size in [best.parameters[each.name]]
    )
    doubt = "" if best.explains else ", which does not explain the data"
    return f"{found.wheel}: {best.meaning}{': ' * bool(sizes)}{sizes} (probability {best.probability:.0%}{doubt})"


def _draw_band(axis: Axes, band: Band) -> None:
    label, size = SIZES[band.observation.signal]
    ms = 1e3 * band.time
    low, high = (band.fitted + sign * BAND * band.spread for sign in (-1, 1))
    axis.fill_between(ms, low / size, high / size, color=COLOURS[1], alpha=0.25, lw=0, label="90 % band")
    axis.plot(ms, band.measured / size, ".", ms=2.5, color="#444444", label="data")
    axis.plot(ms, band.fitted / size, color=COLOURS[0], lw=1.0, label="fit")
    axis.set_xlim(ms[0], ms[-1])
    axis.set_xlabel("time since the peak (ms)")
    axis.set_ylabel(label)
    axis.set_title(f"{band.observation.source}, {3.6 * band.observation.speed:.4g} km/h", fontsize=10, loc="left")
    axis.legend(frameon=False, ncols=3, loc="upper right")


def _draw_sizes(axis: Axes, fit: KindFit) -> None:
    size = KINDS[fit.kind].unknowns[0]
    values, told = 1e3 * fit.draws[:, 0], fit.parameters[size.name]
    axis.hist(values, bins=30, density=True, color=COLOURS[1], alpha=0.5)
    for edge in (told.low, told.high):
        axis.axvline(1e3 * edge, color=COLOURS[0], lw=1.0, ls="--")
    axis.axvline(1e3 * told.estimate, color=COLOURS[0])
    axis.set_xlim(1e3 * size.low, 1e3 * size.high)
    axis.set_yticks([])
    axis.set_xlabel(f"{size.meaning} (mm); lines: median and 90 % interval")
    axis.set_ylabel("probability density")
    axis.set_title(f"{fit.meaning}, probability {np.round(100 * fit.probability):.0f} %", fontsize=10, loc="left")
