"""Supports along a line that is not the same everywhere."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...runtime.arrays import Real
from ...track.supports import Along, along
from ...track.track import Track
from ..figures import COLOURS

RAILS = ("rail 1", "rail 2")


def uneven(track: Track) -> tuple[str, ...]:
    """Supports that differ along the line, ``pad`` and ``ballast``; none on a track that is the same everywhere."""
    if track.line is None:
        return ()
    found = along(track.line)
    kinds = {"pad": np.ptp(found.pad_stiffness) > 0, "ballast": np.ptp(found.ballast_stiffness) > 0}
    kinds["ballast"] |= bool(np.isfinite(found.gap).any())
    return tuple(kind for kind, differs in kinds.items() if differs)


def draw_supports(axes: Axes, track: Track, kind: str) -> None:
    """Stiffness (``pad`` or ``ballast``) under both rails, sleeper by sleeper; gaps under sleepers are marked."""
    assert track.line is not None
    found: Along = along(track.line)
    base = track.pad.stiffness if kind == "pad" else track.ballast.stiffness / 2  # type: ignore[union-attr]
    multiples = getattr(found, f"{kind}_stiffness")
    sleepers = np.arange(len(multiples))
    for side, marker in ((0, "o"), (1, "x")):
        axes.plot(
            sleepers,
            multiples[:, side] * base / 1e6,
            marker,
            color=COLOURS[side],
            markersize=4,
            linestyle="-",
            linewidth=0.6,
            label=RAILS[side],
        )
    if kind == "ballast":
        _mark_gaps(axes, found.gap)
    axes.set_ylim(bottom=0.0)
    axes.margins(y=0.15)
    axes.set_xlim(-0.5, len(sleepers) - 0.5)
    axes.set_xlabel("sleeper")
    axes.set_ylabel(f"{kind} stiffness\nper rail (MN/m)")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, fontsize=9, borderaxespad=0.2)


def _mark_gaps(axes: Axes, gap: Real) -> None:
    """A band at every sleeper that hangs, on either side."""
    hanging = np.flatnonzero(np.isfinite(gap).any(axis=1))
    widths = gap[np.isfinite(gap)] * 1e3
    for number, sleeper in enumerate(hanging):
        label = f"hangs, gap {widths.min():g}" + (f" to {widths.max():g}" if np.ptp(widths) else "") + " mm"
        axes.axvspan(sleeper - 0.4, sleeper + 0.4, color="#e69f00", alpha=0.4, lw=0, label="" if number else label)
