"""``spectrum``: frequencies, one-third-octave bands, orders, or the mean turn of a signal in a bag."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ..bags.signals import Signal
    from ..runtime.arrays import Real

SHOWN = 20
"""Rows of a table for people; ``--json`` and ``--out`` have all."""


class _Spectrum(NamedTuple):
    """What is printed: columns of equal length with their units in their names, and facts about all of them."""

    kind: str
    facts: dict[str, Any]
    columns: dict[str, Real]
    shown: list[int]
    """Rows of the table for people."""


def run_spectrum(options: argparse.Namespace) -> int:
    """Print a spectrum of a signal of a bag; returns the exit status."""
    from ..bags import read_bag
    from ..bags.signals import signal_of, wheel_of
    from ..errors import InputError
    from ..runtime.output_files import require_new
    from .console import print_object, terminal

    if options.out is not None:
        if options.out.suffix.lower() != ".csv":
            raise InputError(f"--out {options.out} is no table: give a name that ends in .csv")
        require_new([options.out], overwrite=False)
    if options.resolution is not None and not options.resolution > 0.0:
        raise InputError(f"--resolution = {options.resolution:g} Hz is out of range: give more than 0 Hz")
    recording = read_bag(options.bag, start=options.start, stop=options.stop)
    signal = signal_of(recording, options.signal)
    if options.orders or options.average:
        found = _over_angle(signal, wheel_of(recording), average=options.average)
    else:
        found = _over_frequency(signal, options.resolution, third_octave=options.third_octave)
    if options.out is not None:
        _write(found, options.out)
    if options.json:
        columns = {name: values.tolist() for name, values in found.columns.items()}
        facts = {"bag": str(options.bag), "signal": signal.name, "unit": signal.unit}
        print_object({**facts, "kind": found.kind, **found.facts, **columns})
        return 0
    console = terminal()
    console.print(_table(signal, found))
    if options.out is not None:
        console.print(f"all rows: {options.out}", highlight=False, soft_wrap=True)
    return 0


def _over_frequency(signal: Signal, resolution: float | None, *, third_octave: bool) -> _Spectrum:
    import numpy as np

    from ..samples.spectra import density, reference_of, third_octaves

    values, rate = signal.evenly()
    found, reference = density(values, rate, resolution), reference_of(signal.unit)
    facts = {
        "rate_Hz": rate,
        "resolution_Hz": found.step,
        "segments": found.segments,
        "rms": float(np.sqrt(found.mean_square)),
        "reference": reference,
    }
    if third_octave:
        bands = third_octaves(found)
        levels = np.maximum(bands.levels(reference), -999.0)
        columns = {"frequency_Hz": bands.middle, "rms": np.sqrt(bands.mean_square), "level_dB": levels}
        return _Spectrum("third_octave", facts, columns, [*range(len(levels))])
    inner = found.density[1:-1]
    peaks = 1 + np.flatnonzero((inner > found.density[:-2]) & (inner >= found.density[2:]))
    highest = sorted(peaks[np.argsort(-found.density[peaks])][:SHOWN].tolist())
    columns = {"frequency_Hz": found.frequency, "density_per_Hz": found.density}
    return _Spectrum("narrow_band", facts, columns, highest)


def _over_angle(signal: Signal, wheel: tuple[float, float], *, average: bool) -> _Spectrum:
    import numpy as np

    from ..samples.orders import averaged, orders, over_angle

    circumference, origin = wheel
    turns = over_angle(signal.values, signal.position, circumference, origin)
    facts = {"turns": len(turns.turns), "first_turn": turns.first, "circumference_m": circumference}
    if average:
        mean = averaged(turns)
        columns = {"angle_rad": turns.angles, "mean": mean.mean, "deviation": mean.rest}
        shown = [*range(0, len(mean.mean), len(mean.mean) // SHOWN), int(np.abs(mean.mean).argmax())]
        return _Spectrum("average", facts, columns, sorted({*shown}))
    found = orders(turns)
    columns = {"order": found.order, "rms": np.sqrt(found.mean_square)}
    return _Spectrum("orders", facts, columns, [*range(SHOWN + 1)])


def _write(found: _Spectrum, path: Path) -> None:
    import csv

    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(found.columns)
        rows.writerows(zip(*(values.tolist() for values in found.columns.values()), strict=True))


def _table(signal: Signal, found: _Spectrum) -> Any:
    from rich.table import Table

    unit = signal.unit or "1"
    units = {"frequency_Hz": "Hz", "order": "", "angle_rad": "rad", "density_per_Hz": f"({unit})²/Hz"}
    titles = {"rms": f"rms, {unit}", "level_dB": f"level, dB re {found.facts.get('reference', 1):g} {unit}"}
    facts = ", ".join(f"{name} {value:.6g}" for name, value in found.facts.items() if name != "reference")
    table = Table(title=f"{signal.name}: {found.kind.replace('_', ' ')}", caption=facts)
    for name in found.columns:
        what = name.partition("_")[0]
        own = f"{what}, {units[name]}" if units.get(name) else what if name in units else f"{what}, {unit}"
        table.add_column(titles.get(name, own), justify="right")
    for row in found.shown:
        table.add_row(*(f"{values[row]:.5g}" for values in found.columns.values()))
    return table
