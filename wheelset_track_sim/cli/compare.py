"""``compare``: a recorded run beside measured loads or stresses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.table import Table

from ..bags import Bag
from ..twin.measured import Comparison, Matching, Reading, compare, read_measurement
from ..twin.measured.comparison import impact_rows, remarks, rows
from .console import print_object, terminal


def compared(
    bag: Path, measured: Path, matching: Matching, reading: Reading, *, json: bool, warnings: Sequence[str] = ()
) -> int:
    """Compare a bag with a measurement and print how well they agree; returns the exit status."""
    found = compare(Bag(bag).blocks(), read_measurement(measured, reading), matching)
    console = terminal()
    if json:
        print_object(as_mapping(found) | {"warnings": [*warnings]})
        return 0
    console.print(table(found))
    if found.impacts:
        console.print(impact_table(found))
    for line in remarks(found):
        console.print(line, highlight=False, soft_wrap=True)
    return 0


def as_mapping(found: Comparison) -> dict[str, Any]:
    """The object that ``compare --json`` prints; what is undefined is null."""
    unit = found.unit
    mapping = {
        "measured": str(found.source),
        "axis": found.axis,
        f"lag_{unit}": found.lag,
        f"begin_{unit}": float(found.begin),
        "begin_utc": found.begin_utc,
        f"lag_uncertainty_{unit}": found.uncertainty,
        "correlation": found.quality.coefficient,
        "second_best_correlation": found.quality.second,
        f"step_{unit}": found.step,
        "samples": len(found.at),
        f"from_{unit}": float(found.at[0]),
        f"to_{unit}": float(found.at[-1]),
        "signals": {name: asdict(each) for name, each in zip(found.names, found.agreement, strict=True)},
        "impacts": [
            {"wheel": pair.signal, f"at_{unit}": pair.at, "measured_N": pair.measured, "simulated_N": pair.simulated}
            for pair in found.impacts
        ],
        "left_out": [*found.left_out],
    }
    return {name: _defined(value) for name, value in mapping.items()}


def _defined(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _defined(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_defined(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(found: Comparison) -> Table:
    """Error measures of each signal, for people."""
    shown_as = Table(title=f"{found.source.name} beside the simulation", title_justify="left")
    shown_as.add_column("")
    for name in found.names:
        shown_as.add_column(name, justify="right", no_wrap=True)
    for label, *cells in rows(found):
        shown_as.add_row(label, *cells)
    return shown_as


def impact_table(found: Comparison) -> Table:
    """Peaks of the impacts that either shows."""
    shown_as = Table(title="impacts", title_justify="left")
    for heading in (found.axis, "wheel", "measured", "simulated", "error"):
        shown_as.add_column(heading, justify="right", no_wrap=True)
    for cells in impact_rows(found):
        shown_as.add_row(*cells)
    return shown_as
