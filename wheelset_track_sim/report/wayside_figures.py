"""What detectors read of a passage, beside the contact forces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from ..inputs import units
from ..wayside.detector import RAILS, Gauge
from ..wayside.watch import WaysidePassage
from .figures import COLOURS, new_figure, write_picture

RAIL_COLOURS = dict(zip(RAILS, COLOURS, strict=False))
STYLES = ("-", "--", ":", "-.")
"""Of the channels of one rail in a panel that are of different types."""


def plot_passages(found: Sequence[WaysidePassage], spacing: float, path: Path, run: str) -> Path:
    """Write a picture of passages (PNG, SVG or PDF): a panel for each unit of a detector, over the wheelset's position.

    Raises InputError if the path cannot be written.
    """
    panels = [
        (passage, unit)
        for passage in found
        for unit in dict.fromkeys(channel.unit for channel in passage.reading.detector.channels)
    ]
    with new_figure(2.6 * len(panels) + 0.8, f"What detectors read of {run}", f"wayside {run}") as figure:
        for axes, (passage, unit) in zip(figure.subplots(len(panels), squeeze=False)[:, 0], panels, strict=True):
            draw_passage(axes, passage, unit, spacing)
        return write_picture(figure, path)


def draw_passage(axes: Axes, passage: WaysidePassage, unit: str, spacing: float) -> None:
    """Channels of one unit; those in N beside the true contact forces."""
    reading = passage.reading
    shown = units.for_people(unit)
    channels = [each for each in reading.detector.channels if each.unit == unit]
    types = [*dict.fromkeys(each.type for each in channels)]
    first, last = reading.places[[0, -1]]
    for index, sleeper in enumerate(np.arange(np.ceil(first / spacing), last // spacing + 1) * spacing):
        axes.axvline(sleeper, color="#d9d9d9", lw=1.0, zorder=0, label="" if index else "sleeper")
    if unit == "N":
        at = (reading.first_step + np.arange(len(reading.forces))) * reading.step_length
        for rail, force in reversed([*zip(RAILS, reading.forces.T, strict=True)]):
            label = f"contact force, {rail.replace('rail_', 'wheel ')}"
            axes.plot(at, force / shown.size, color=RAIL_COLOURS[rail], lw=0.8, alpha=0.45, label=label)
    labelled: set[str] = set()
    for channel in reversed(channels):
        values = reading.channel(channel.name) / shown.size
        label = _label(channel)
        axes.plot(
            reading.places,
            values,
            STYLES[types.index(channel.type) % len(STYLES)],
            color=RAIL_COLOURS[channel.on],
            lw=1.2,
            label="" if label in labelled else label,
        )
        labelled.add(label)
    axes.set(xlim=(first, last), xlabel="position of the wheelset along the track (m)")
    name = passage.topic.partition("/")[2]
    axes.set_ylabel(units.with_unit(name, shown.name))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, frameon=False, fontsize=8, handlelength=1.2)


def _label(channel: Gauge) -> str:
    return f"{channel.type.replace('_', ' ')}, {channel.on.replace('_', ' ')}"
