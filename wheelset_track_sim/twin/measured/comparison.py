"""A measurement on the axis of a simulation, and how well the two agree."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from decimal import Decimal
from pathlib import Path

import numpy as np

from ...errors import InputError, warn
from ...inputs.schema import check, quantity, unknown
from ...runtime.arrays import Real
from ...samples.block import SampleBlock
from ...wheelset.reduced import COMPONENTS
from .agreement import Agreement, PairedImpact, agreement, paired
from .alignment import Lag, align
from .measurement import UNITS, WHEELS, Axis, Measurement, evenly

SEPARATION = 0.1
"""Distance without a force above the threshold that ends an impact, m."""
GAINS = (0.1, 10.0)
"""Gain of a force beyond which the two are hardly of the same quantity."""
SINCE_1970 = 1e8
"""Times of a measurement from here on count from 1970, s."""
YEAR_10000 = 253402300800
"""Seconds from 1970 to the first day that dates do not reach."""


@dataclass(frozen=True)
class Matching:
    """How a measurement is put beside a simulation."""

    lag: float | None = None
    """Where the measurement's zero lies on the simulation's axis, s or m, about; None if it may lie anywhere."""
    origin: float | None = None
    """Where the simulation's zero lies on the measurement's axis, s or m, about: the same with the other sign."""
    reach: float = quantity("", 0.0, 1e6, "how far from the given lag the best one may lie, in s or m,", default=0.02)
    threshold: float = quantity("N", 1e3, 5e6, "the contact force above which an impact begins", default=200e3)

    def __post_init__(self) -> None:
        check(self)
        if self.lag is not None and self.origin is not None:
            raise InputError(f"lag = {self.lag:g} and origin = {self.origin:g} exclude each other: give one of them")
        for name, value in (("lag", self.lag), ("origin", self.origin)):
            if value is not None and not math.isfinite(value):
                raise InputError(f"{name} = {value} is not finite: give an approximate value, in s or m")


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both on one axis, with one sampling rate and in one band: those of the slower of the two."""

    source: Path
    axis: Axis
    at: Real
    """(n,) on the simulation's axis, s or m."""
    names: tuple[str, ...]
    measured: Real
    """(n, signals), N or Pa."""
    simulated: Real
    """(n, signals), N or Pa."""
    lag: float
    """Where the measurement's zero lies on the simulation's axis, s or m."""
    begin: Decimal
    """Where the simulation's zero lies on the measurement's axis, s or m: ``-lag``, exact for time stamps, too."""
    quality: Lag
    """The same in steps, with how sure it is."""
    step: float
    """From sample to sample, s or m."""
    left_out: tuple[str, ...]
    """Signals that were measured and are not in the simulation."""
    agreement: tuple[Agreement, ...]
    """Of each signal."""
    impacts: tuple[PairedImpact, ...]

    @property
    def unit(self) -> str:
        """Of the axis."""
        return UNITS[self.axis]

    @property
    def begin_utc(self) -> str | None:
        """Date and time at which the simulation begins; None if the measurement has no such time stamps."""
        if self.axis != "time" or not SINCE_1970 <= self.begin < YEAR_10000:
            return None
        moment = datetime.fromtimestamp(int(self.begin), timezone.utc)
        return f"{moment:%Y-%m-%dT%H:%M:%S}.{int(self.begin % 1 * 10**6):06d}Z"

    @property
    def uncertainty(self) -> float:
        """Standard deviation of the lag, s or m."""
        return self.quality.uncertainty * self.step


def compare(blocks: Iterable[SampleBlock], measurement: Measurement, matching: Matching | None = None) -> Comparison:
    """Put a measurement beside a simulation and compare them where both are.

    Raises InputError if they have no signal in common, if one of them has gaps, or if it cannot be told where the
    measurement lies on the axis.
    """
    matching = matching or Matching()
    names, at, signals = simulated_signals(blocks, measurement)
    speed = (at[-1, 1] - at[0, 1]) / (at[-1, 0] - at[0, 0])
    axis = at[:, 0 if measurement.axis == "time" else 1]
    ours = Measurement(Path("the simulation"), measurement.axis, axis, dict(zip(names, signals.T, strict=True)))
    theirs = Measurement(
        measurement.source,
        measurement.axis,
        measurement.at,
        {name: measurement.signals[name] for name in names},
        measurement.origin,
    )
    simulation = evenly(ours, widest=math.inf)  # no step is missing: one that is wide is run slowly
    record = evenly(theirs)
    step = max(simulation.step, record.step)
    grid, record_grid = (np.arange(of.count(step), dtype=np.float64) * step for of in (simulation, record))
    simulated = simulation.at(grid, step)
    within = (-math.inf, math.inf)
    about = matching.lag if matching.origin is None else -matching.origin
    if about is not None:
        middle = (float(Decimal(about) + measurement.origin) + record.start - simulation.start) / step
        within = middle - matching.reach / step, middle + matching.reach / step

    def lag_of(steps: float) -> Decimal:
        return Decimal(simulation.start - record.start + steps * step) - measurement.origin

    found = align(
        simulated, record.at(record_grid, step), within, lambda steps: f"{lag_of(steps):.4f} {UNITS[measurement.axis]}"
    )
    first, end = max(0, math.ceil(found.steps)), min(len(grid), math.floor(found.steps + len(record_grid) - 1) + 1)
    simulated, measured = simulated[first:end], record.at(grid[first:end] - found.steps * step, step)
    axis = simulation.start + grid[first:end]
    separation = SEPARATION if measurement.axis == "position" else SEPARATION / float(speed)
    forces = [column for column, name in enumerate(names) if name in WHEELS]
    agreements = tuple(agreement(theirs, ours) for ours, theirs in zip(simulated.T, measured.T, strict=True))
    for column in forces:
        gain = agreements[column].gain
        if not math.isnan(gain) and not GAINS[0] <= gain <= GAINS[1]:
            warn(
                f"{measurement.source}: gain of {names[column]} is {gain:.3g}, measured over simulated, and up to "
                f"{GAINS[1]:g} may come of other damage: check the unit and the channel"
            )
    return Comparison(
        source=measurement.source,
        axis=measurement.axis,
        at=axis,
        names=names,
        measured=measured,
        simulated=simulated,
        lag=float(lag_of(found.steps)),
        begin=-lag_of(found.steps),
        quality=found,
        step=step,
        left_out=tuple(name for name in measurement.signals if name not in names),
        agreement=agreements,
        impacts=tuple(
            pair
            for column in forces
            for pair in paired(
                names[column], axis, measured[:, column], simulated[:, column], matching.threshold, separation
            )
        ),
    )


def simulated_signals(blocks: Iterable[SampleBlock], measurement: Measurement) -> tuple[tuple[str, ...], Real, Real]:
    """Names that a simulation and a measurement share, time and position (n, 2) of each step, signals (n, shared)."""
    names: tuple[str, ...] | None = None
    at, signals = [], []
    end = 0
    for block in blocks:
        if names is None:
            names = _shared(measurement, block.nodes)
        elif block.first_step != end:
            raise InputError(
                f"the simulation has a gap: step {block.first_step} follows step {end - 1}, give a bag without gaps"
            )
        end = block.first_step + len(block)
        rows = np.arange(len(block)) * block.step_period
        at.append(np.stack([block.time + rows, block.position + rows * block.speed], axis=-1))
        signals.append(np.stack([signal_of(block, name) for name in names], axis=-1))
    if names is None:
        raise InputError("the simulation has no samples: give a bag of a run")
    return names, np.concatenate(at), np.concatenate(signals)


def signal_of(block: SampleBlock, name: str) -> Real:
    """A signal of a block by its name, (n,)."""
    if name in WHEELS:
        return block.forces[:, WHEELS.index(name)]
    node, _, component = name.rpartition("_")
    if node in block.nodes and component in COMPONENTS:
        return block.stresses[:, block.nodes.index(node), COMPONENTS.index(component)]
    return block.max_principal[:, block.nodes.index(name)]


def _shared(measurement: Measurement, nodes: Sequence[str]) -> tuple[str, ...]:
    known = [*WHEELS, *nodes, *(f"{node}_{component}" for node in nodes for component in COMPONENTS)]
    found = tuple(name for name in measurement.signals if name in known)
    if not found:
        name = next(iter(measurement.signals))
        raise InputError(unknown("signal of the simulation", f"{measurement.source}: {name!r}", name, known))
    return found


def rows(found: Comparison) -> list[tuple[str, ...]]:
    """Label and a cell for each signal: kN, MPa, %."""
    scales = [(1e3, "kN") if name in WHEELS else (1e6, "MPa") for name in found.names]
    lines: list[tuple[str, ...]] = []
    for label, field in (
        ("max, measured", "max_measured"),
        ("max, simulated", "max_simulated"),
        ("peak error", "peak_error"),
        ("mean error", "mean_error"),
        ("RMS error", "rms_error"),
    ):
        values = [getattr(each, field) / scale for each, (scale, _) in zip(found.agreement, scales, strict=True)]
        lines.append((label, *(f"{value:.2f} {unit}" for value, (_, unit) in zip(values, scales, strict=True))))
    for label, field in (
        ("RMS error / RMS measured", "relative_error"),
        ("magnitude error (Sprague, Geers)", "magnitude_error"),
        ("phase error (Sprague, Geers)", "phase_error"),
        ("comprehensive error (Russell)", "russell_comprehensive_error"),
    ):
        lines.append((label, *(f"{100 * getattr(each, field):.1f} %" for each in found.agreement)))
    lines.append(("correlation", *(f"{each.correlation:.4f}" for each in found.agreement)))
    lines.append(("gain, measured / simulated", *(f"{each.gain:.3f}" for each in found.agreement)))
    return lines


def impact_rows(found: Comparison) -> list[tuple[str, ...]]:
    """Cells of each impact, for people."""

    def force(value: float) -> str:
        return "none" if math.isnan(value) else f"{value / 1e3:.1f} kN"

    return [
        (
            f"{pair.at:.4f} {found.unit}",
            pair.signal.removeprefix("wheel_"),
            force(pair.measured),
            force(pair.simulated),
            "" if math.isnan(pair.error) else f"{100 * pair.error:+.1f} %",
        )
        for pair in found.impacts
    ]


def remarks(found: Comparison) -> list[str]:
    """What to know about the comparison, in lines."""
    second = "" if math.isnan(found.quality.second) else f", {found.quality.second:.3f} at any other lag"
    scale, unit = (1e3, "ms") if found.axis == "time" else (1e3, "mm")
    begin = f" The simulation begins at {found.begin_utc} ({found.begin:.6f} s)." if found.begin_utc else ""
    lines = [
        f"Zero of the measurement is at {found.lag:.6f} {found.unit} of the simulation (standard deviation "
        f"{scale * found.uncertainty:.2g} {unit}): correlation {found.quality.coefficient:.4f} there{second}.{begin}",
        f"Compared over {found.at[0]:.4f} to {found.at[-1]:.4f} {found.unit} with a sample each "
        f"{scale * found.step:.4g} {unit}, in the band of the slower of the two.",
    ]
    if found.left_out:
        lines.append(f"Not in the simulation, and left out: {', '.join(found.left_out)}.")
    return lines
