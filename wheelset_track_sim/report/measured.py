"""Section of the page: the run beside what was measured."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np
from bokeh.models import ColumnDataSource, Range1d
from bokeh.models.layouts import LayoutDOM

from ..runtime.arrays import Real
from ..twin.measured.comparison import Comparison, impact_rows, remarks, rows
from ..twin.measured.measurement import WHEELS
from .plots import below_one_another, curves, over_an_axis

MOST = 20_000
"""Points of a curve: a longer one is drawn as the smallest and the largest value of each stretch."""


def section(found: Comparison, plot: str) -> str:
    """Both curves, and how well they agree."""
    words = " ".join(remarks(found))
    text = (
        f"<h2>Beside measured: {escape(found.source.name)}</h2><p>{escape(words)}</p>{plot}"
        f'<div class="scroll">{_table(("", *found.names), rows(found), "measures")}</div>'
        '<p class="quiet">Simulated less measured, of the dynamic part but for RMS error and means. Magnitude and '
        "phase after Sprague and Geers (2004), comprehensive error after Russell (1997). Gain: the factor on the "
        "simulation that leaves least of the measurement.</p>"
    )
    if found.impacts:
        heads = (found.axis, "wheel", "measured", "simulated", "error")
        text += f'<div class="list">{_table(heads, impact_rows(found), "measured-impacts")}</div>'
    return text


def _table(heads: Sequence[str], lines: Iterable[Sequence[str]], name: str) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in heads)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in line)}</tr>" for line in lines)
    return f'<table class="compared" id="{name}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


def measured_plots(found: Comparison) -> LayoutDOM:
    """One plot a signal, measured and simulated on one axis."""
    at, values = drawn(found.at, np.concatenate([found.simulated, found.measured], axis=1))
    shared = Range1d(at[0], at[-1], bounds=(at[0], at[-1]), min_interval=10 * found.step, name="measured-axis")
    plots = []
    for index, name in enumerate(found.names):
        scale, unit = (1e3, "kN") if name in WHEELS else (1e6, "MPa")
        source = ColumnDataSource(
            {"time": at}
            | {
                f"value{number}": (values[:, index + number * len(found.names)] / scale).astype(np.float32)
                for number in range(2)
            }
        )
        plot = over_an_axis(f"{name.replace('_', ' ')} ({unit})", shared, 240)
        curves(plot, source, range(2), ("simulated", "measured"), unit)
        plots.append(plot)
    plots[-1].xaxis.axis_label = "simulated time (s)" if found.axis == "time" else "position along the track (m)"
    return below_one_another(plots)


def drawn(at: Real, values: Real) -> tuple[Real, Real]:
    """Axis and values (n, curves) in ``MOST`` points at most, without losing a peak."""
    size = -(-2 * len(at) // MOST)
    if size <= 2:
        return at, values
    starts = np.arange(0, len(at), size)  # the last stretch may be shorter
    both = np.stack([np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)], axis=1)
    middles = (starts + np.append(starts[1:], len(at))) // 2
    return at[np.stack([starts, middles], axis=1)].ravel(), both.reshape(2 * len(starts), -1)
