"""The blind zone of shear bridges: what they read of the same hit at all places of the bay.

A wheel with the scenario's damage passes the shipped detectors with the damage at one angle after the other. So it
strikes the rail at places all along a turn, which is no whole number of bays. For each place there is the true peak of
the contact force, and what a bridge and the array read.

The dynamic part of a reading is scaled to a hit of ``HIT``: with the share d = (read - static) / (true - static) of the
dynamic force, the detector reads static + d (HIT - static).
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..irregularities import Irregularity
from ..report.figures import COLOURS, new_figure
from ..runtime.arrays import Real
from ..runtime.progress import Progress, unreported
from ..samples.block import SampleBlock
from ..scenario import Scenario
from ..simulation.models import load_models
from ..simulation.passages import Passages
from ..wayside.detector import Detector, ShearBridge, load_detector
from ..wayside.evaluation import evaluated
from ..wayside.history import wayside_reading, window
from . import drawing

DETECTORS = ("shear_single", "shear_array")
"""One bridge on a bay, and bridges on several bays."""
PLACES = 181
"""Angles of the damage, around a turn."""
REFERENCE = 6.0
"""Where angle 0 meets the rail, m; detectors stand there, so that a run before them is theirs, too."""
CLEAR = 0.2
"""Distance of damage from the contact at the start of a passage, m."""
HIT, LEVELS = 300e3, (250e3, 200e3)
"""A hit, and readings that it should reach, N."""


class Hits(NamedTuple):
    """One detector over all places; N, m."""

    place: Real
    """(n,) Of a hit, from the sleeper before it for one bridge, from the beginning of the detector for several."""
    true: Real
    """(n,) Largest contact force."""
    read: Real
    """(n,) Peak that the detector reads."""

    def of_hit(self, static: float) -> Real:
        """What the detector reads of a hit of ``HIT`` there, (n,)."""
        scaled: Real = static + (self.read - static) / (self.true - static) * (HIT - static)
        return scaled

    def missed(self, static: float) -> str:
        """Shares of such hits that read below ``LEVELS``, in words."""
        shares = (float(np.mean(self.of_hit(static) < level)) for level in LEVELS)
        return " and ".join(
            f"{100 * share:.0f} % below {level / 1e3:g} kN" for share, level in zip(shares, LEVELS, strict=True)
        )


def draw(out: Path, scenario: Scenario, progress: Progress | None = None) -> list[Path]:
    """Write ``blind_zone`` into ``out``: readings and true peaks over the place of the hit.

    Raises InputError for a scenario without damage on wheel 1, and for a track on which the detectors cannot stand.
    """
    one, array = hits(scenario, progress=progress)
    static = scenario.wheel_load
    paths = _figure(out, scenario, one, array)
    for name, found in zip(DETECTORS, (one, array), strict=True):
        columns = {
            "place of the hit (m)": found.place,
            "true peak (N)": found.true,
            "peak read (N)": found.read,
            f"peak read of a hit of {HIT / 1e3:g} kN (N)": found.of_hit(static),
        }
        paths.append(drawing.table(out, f"blind_zone_{name}", columns))
    return paths


def hits(scenario: Scenario, places: int = PLACES, progress: Progress | None = None) -> tuple[Hits, Hits]:
    """What a bridge reads of hits all over its bay, and what the array reads of wheels in all positions."""
    told = progress or unreported
    damage = [each for each in scenario.irregularities if each.on == "wheel_1" and hasattr(each, "angle")]
    if not damage:
        raise InputError("the blind zone needs damage on wheel_1 at an angle: give a breakout or a flat")
    single, several = (load_detector(name) for name in DETECTORS)
    spacing, dx = scenario.track.spacing, scenario.step_length
    base = dataclasses.replace(scenario, irregularities=(), reference_position=REFERENCE, sensors=(), wayside=())
    end = max(window(each, base.track, REFERENCE, dx)[1] for each in (single, several)) * dx
    models = load_models(base, progress, tables="smooth")
    early, late = (
        Passages(base, models=models, before=REFERENCE - start, after=end - REFERENCE) for start in (0.0, spacing)
    )
    turn = scenario.steps_per_revolution * dx
    found: tuple[list[tuple[float, ...]], list[tuple[float, ...]]] = ([], [])
    for number, angle in enumerate((2 * math.pi * np.arange(places) / places).tolist()):
        hit = REFERENCE + angle / (2 * math.pi) * turn
        at_start = abs(math.remainder(hit, turn)) < CLEAR
        block = (late if at_start else early).run([_turned(each, angle) for each in damage])
        bay = math.floor(hit / spacing + 1e-9) * spacing
        found[0].append((hit - bay, *_peaks(single, base, bay, block, hit)))
        found[1].append((hit - REFERENCE, *_peaks(several, base, REFERENCE, block)))
        told("passages", (number + 1) / places)
    one, array = (Hits(*np.array(sorted(each)).T) for each in found)
    return one, array


def _turned(item: Any, angle: float) -> Irregularity:
    turned: Irregularity = dataclasses.replace(item, angle=angle)
    return turned


def _peaks(
    detector: Detector, scenario: Scenario, position: float, block: SampleBlock, near: float = math.nan
) -> tuple[float, float]:
    """True peak of wheel 1, within a bay of the place ``near`` if that is given, and the peak that is read."""
    dx = scenario.step_length
    reading = wayside_reading(
        detector,
        scenario.track,
        position,
        block.forces,
        speed=block.speed,
        first_step=block.first_step,
        step_length=dx,
    )
    at = (reading.first_step + np.arange(len(reading.forces))) * dx
    forces = reading.forces[~(np.abs(at - near) > scenario.track.spacing), 0]
    return float(forces.max()), evaluated(reading)[0].read.peak


def _figure(out: Path, scenario: Scenario, one: Hits, array: Hits) -> list[Path]:
    single, several = (load_detector(name) for name in DETECTORS)
    static, spacing = scenario.wheel_load, scenario.track.spacing
    bays = sum(channel.on == "rail_1" for channel in several.channels)
    title = f"What shear bridges read of the hits of {scenario.name}, {3.6 * scenario.speed:g} km/h"
    made = (
        f"{len(array.place)} angles of the damage; peaks are read with the wheel between the gauges. Of hits with "
        f"{HIT / 1e3:g} kN the bridge of their bay reads {one.missed(static)}. Of wheels with such a hit a turn the "
        f"array of {bays} bays reads {array.missed(static)}"
    )
    with new_figure(6.4, title, made) as figure:
        upper, lower = figure.subplots(2, 1)
        _panel(upper, one, static, f"place of the hit in the bay, from the sleeper (m): {single.name}")
        bridge = single.channels[0]
        if isinstance(bridge, ShearBridge):
            upper.axvspan(bridge.x - bridge.length / 2, bridge.x + bridge.length / 2, color="#eeeeee", zorder=0)
        upper.set_xlim(0.0, spacing)
        _panel(lower, array, static, f"place of the first hit in the array (m): {several.name}")
        lower.set_xlim(array.place[0], array.place[-1])
        return drawing.save(out, "blind_zone", figure)


def _panel(axes: Axes, found: Hits, static: float, label: str) -> None:
    axes.axhline(static / 1e3, color="#888888", lw=0.8, ls=(0, (4, 3)), label="static")
    axes.plot(found.place, found.true / 1e3, color=COLOURS[1], label="true peak")
    axes.plot(found.place, found.read / 1e3, color=COLOURS[0], label="peak read")
    axes.set(xlabel=label, ylabel="force (kN)", ylim=(0.0, None))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, fontsize=9)
