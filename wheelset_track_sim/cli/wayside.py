"""``wayside``: what detectors beside the track read of a scenario that is simulated, or of a bag."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from ..bags.bag import Bag
from ..errors import InputError, RecordingError
from ..inputs.amounts import in_unit
from ..report.figures import PICTURES
from ..report.wayside_figures import plot_passages
from ..runtime.output_files import require_new
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..scenario import Scenario, load_scenario
from ..simulation.simulator import Simulator
from ..wayside.detector import WaysideDetector, check_detectors, load_detector
from ..wayside.evaluation import WheelLoads, WheelVerdict, channel_values
from ..wayside.history import window
from ..wayside.watch import WaysidePassage, passages
from .console import print_object, terminal
from .fatigue import is_bag, recorded_scenario
from .progress import shown

DETECTOR = "shear_array"
"""Detector of a scenario that has none."""
CHUNK = 5556
"""Steps simulated at once."""
LONGEST = 1e5
"""Longest way to a detector, m."""


def wayside(
    run: str,
    changes: Sequence[str],
    detectors: Sequence[str],
    at: float | None,
    out: Path | None,
    *,
    overwrite: bool,
    json: bool,
    warnings: Sequence[str] = (),
) -> int:
    """Print what detectors read of a run, and write their channels; returns the exit status."""
    if out is not None:
        if out.suffix.lower() not in (".csv", *PICTURES):
            raise InputError(f"--out {out} is neither a table nor a picture: give .csv, {', '.join(PICTURES)}")
        require_new([out], overwrite=overwrite)
    if at is not None and not 0.0 <= at <= LONGEST:
        raise InputError(f"--at {at:g} m is out of range: give 0 to {LONGEST:g} m")
    bag = is_bag(run)
    if bag and changes:
        raise InputError("--set changes a scenario, and a bag is a run already: leave it out, or give a scenario")
    scenario = _recorded(Path(run)) if bag else load_scenario(run, changes)
    standing = _standing(scenario, detectors, at)
    slowest = math.inf if bag else min([scenario.speed, *(point.speed for point in scenario.speed_plan)])
    check_detectors(standing, scenario.track, slowest / scenario.step_length, scenario.step_length)
    with shown() as progress:
        blocks = Bag(Path(run)).blocks() if bag else _simulated(scenario, standing, progress)
        found = list(passages(standing, scenario.track, scenario.step_length, blocks))
    if missing := [each for each in standing if each.topic not in {passage.topic for passage in found}]:
        raise InputError(
            f"position = {missing[0].position:g} m of detector {missing[0].detector.name} is off the line of {run}: "
            f"it needs the steps {' to '.join(map(str, _window(missing[0], scenario)))} without a gap, give --at"
        )
    if out is not None:
        _write(found, out) if out.suffix.lower() == ".csv" else plot_passages(found, scenario.track.spacing, out, run)
    if json:
        print_object(as_mapping(run, found) | {"warnings": [*warnings]})
        return 0
    console = terminal()
    for passage in found:
        console.print(table(passage))
    if out is not None:
        console.print(f"channels: {out}", highlight=False, soft_wrap=True)
    return 0


def _recorded(path: Path) -> Scenario:
    """Scenario of a bag; raises RecordingError."""
    for state in Bag(path).each_state():
        return recorded_scenario(path, state.scenario)
    raise RecordingError(f"{path} holds no scenario, so its track is unknown: record it with this package")


def _standing(scenario: Scenario, detectors: Sequence[str], at: float | None) -> tuple[WaysideDetector, ...]:
    """Detectors that are named, or else those of the scenario."""
    if not detectors and at is None and scenario.wayside:
        return scenario.wayside
    position = scenario.reference_position if at is None else at
    return tuple(WaysideDetector(load_detector(each), position) for each in detectors or [DETECTOR])


def _window(standing: WaysideDetector, scenario: Scenario) -> tuple[int, int]:
    return window(standing.detector, scenario.track, standing.position, scenario.step_length)


def _simulated(scenario: Scenario, standing: Sequence[WaysideDetector], progress: Progress) -> Iterator[SampleBlock]:
    """Blocks of a run that passes all detectors."""
    simulator = Simulator(scenario, progress)
    simulator.settle()
    steps = 1 + max(_window(each, scenario)[1] for each in standing)
    while simulator.next_step < steps:
        yield simulator.advance(min(CHUNK, steps - simulator.next_step))
        progress(f"simulate {scenario.name}", simulator.next_step / steps)


def as_mapping(run: str, found: Sequence[WaysidePassage]) -> dict[str, Any]:
    """The object that ``wayside --json`` prints: one entry a detector and rail."""
    return {"run": run, "detectors": [_entry(each, verdict) for each in found for verdict in each.verdicts]}


def _entry(passage: WaysidePassage, verdict: WheelVerdict) -> dict[str, Any]:
    reading = passage.reading
    return {
        "name": passage.topic.partition("/")[2],
        "rail": verdict.rail,
        "position_m": reading.position,
        **_loads("", verdict.read),
        **_loads("true_", verdict.true),
        "time_s": passage.time,
        "speed_m_s": passage.speed,
        "band_Hz": reading.detector.band,
        "channels": [
            {
                "name": each.channel.name,
                "type": each.channel.type,
                "position_m": reading.position + each.channel.x,
                "unit": each.channel.unit,
                "max": each.max,
                "min": each.min,
                "rms": each.rms,
            }
            for each in channel_values(reading)
            if each.channel.on == verdict.rail
        ],
    }


def _loads(prefix: str, loads: WheelLoads) -> dict[str, float | None]:
    numbers = {
        "mean_N": loads.mean,
        "peak_N": loads.peak,
        "dynamic_force_N": loads.dynamic_force,
        "dynamic_factor": loads.dynamic_factor,
    }
    return {f"{prefix}{name}": None if math.isnan(value) else value for name, value in numbers.items()}


def table(passage: WaysidePassage) -> Table:
    """One passage for people: reading and truth side by side, then other channels."""
    reading = passage.reading
    shown_as = Table(
        title=f"{passage.topic.partition('/')[2]} at {reading.position:g} m: wheelset at "
        f"{in_unit(passage.speed, 'km/h', 'm/s')}, band {reading.detector.band:g} Hz",
        title_justify="left",
        caption="true: contact force while the detector reads; read: shear bridges with the wheel between their gauges",
        caption_justify="left",
    )
    for heading in ("", "mean", "peak", "dynamic force", "dynamic factor"):
        shown_as.add_column(heading, justify="right" if heading else "left")
    for verdict in passage.verdicts:
        wheel = verdict.rail.replace("rail_", "wheel ")
        for what, loads in (("true", verdict.true), ("read", verdict.read)):
            if not math.isnan(loads.mean):
                forces = (f"{force / 1e3:.1f} kN" for force in (loads.mean, loads.peak, loads.dynamic_force))
                shown_as.add_row(f"{wheel}, {what}", *forces, f"{loads.dynamic_factor:.2f}")
    others = [each for each in channel_values(reading) if each.channel.type != "shear_bridge"]
    if others:
        shown_as.add_section()
        shown_as.add_row("channel", "", "largest", "smallest", "rms", style="bold")
    for each in others:
        numbers = (f"{value:.4g} {each.channel.unit}" for value in (each.max, each.min, each.rms))
        shown_as.add_row(f"{each.channel.name} ({each.channel.type.replace('_', ' ')})", "", *numbers)
    return shown_as


def _write(found: Sequence[WaysidePassage], path: Path) -> None:
    """A row for each sample of each channel."""
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["detector", "channel", "unit", "time_s", "wheelset_m", "value"])
        for passage in found:
            reading, name = passage.reading, passage.topic.partition("/")[2]
            times = (reading.times + passage.time).tolist()
            for channel, values in zip(reading.detector.channels, reading.values.T, strict=True):
                for sample in zip(times, reading.places.tolist(), values.tolist(), strict=True):
                    rows.writerow([name, channel.name, channel.unit, *sample])
