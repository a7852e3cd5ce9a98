"""Tables of a study: CSV in SI for programs, rows of text for people."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..inputs import units
from ..scenario import WHEELS
from ..verdict.limit_set import LimitSet
from . import drawing
from .histories import DISTANCE
from .maps import limits_of
from .outputs import label_of, unit_of
from .results import Results
from .sensitivities import indices as sobol

MOST_ROWS = 30
"""Runs that are shown one by one; of more, the extremes along the longest axis are."""
QUANTILES = (0.05, 0.5, 0.95)
"""Shares of the draws of which a table has the quantiles."""


@dataclass(frozen=True)
class ResultTable:
    """Rows of text under headings with units."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def write_tables(results: Results, out: Path, *, parquet: bool = False) -> list[Path]:
    """Write ``results.csv`` with one row a run, and what else is kept of each run; SI units, in the headings.

    With ``parquet`` each table is also written as a file of Apache Parquet.
    """
    return [
        write(out, name, columns)
        for name, columns in _tables(results)
        for write in ((drawing.table, drawing.parquet) if parquet else (drawing.table,))
    ]


def _tables(results: Results) -> Iterator[tuple[str, dict[str, Any]]]:
    """Names of tables with their columns."""
    indices = range(len(results.runs))
    columns: dict[str, Any] = {}
    for axis in results.axes:
        points = [results.point(index, axis.name) for index in indices]
        values = [point.value if axis.is_numeric else point.label for point in points]
        columns[units.with_unit(axis.name, axis.unit)] = values
    columns["dynamics"] = [run.scenario.dynamics for run in results.runs]
    for name in results.study.outputs:
        columns[units.with_unit(label_of(name), unit_of(name))] = [results.value(index, name) for index in indices]
    for name in results.study.outputs if results.study.places > 1 else ():
        ends = [results.ends(index, name) for index in indices]
        for column, word in enumerate(("smallest", "largest")):
            columns[units.with_unit(f"{label_of(name)}, {word}", unit_of(name))] = [pair[column] for pair in ends]
    for name in results.study.outputs:
        paper = [results.published(index, name) for index in indices]
        if np.isfinite(paper).any():
            columns[f"paper: {units.with_unit(label_of(name), unit_of(name))}"] = paper
    if results.limits is not None:
        columns[_verdict(results.limits)] = [_level(results, index) for index in indices]
    if results.study.outputs:
        yield "results", columns
    for index in sorted(results.found):
        label = re.sub(r"\W+", "_", results.runs[index].label).strip("_")
        if results.study.histories:
            yield f"history_{label}", _history(results, index)
        for name in results.study.pressures:
            yield f"pressure_{label}_{name.replace('.', '_')}", _pressure(results, index, name)


def tables(results: Results) -> Iterator[ResultTable]:
    """Tables for people: all runs or their extremes, and what the paper prints beside."""
    if results.study.outputs:
        if any(axis.distribution for axis in results.axes):
            yield _statistics(results)
            yield from _sensitivities(results)
        else:
            yield _runs(results) if len(results.runs) <= MOST_ROWS else _extremes(results)
    compared = tuple(_compared(results))
    if compared:
        yield ResultTable("Beside the paper", ("run", "quantity", "this study", "paper", "difference"), compared)
    if results.failures:
        rows = tuple((results.runs[index].label, results.failures[index]) for index in sorted(results.failures))
        yield ResultTable("Runs that failed", ("run", "reason"), rows)


def number(value: float) -> str:
    """A value in the unit of its column: four digits, at most two after the point."""
    if math.isnan(value):
        return "–"
    return f"{value:.2f}" if abs(value) < 10 else f"{value:.1f}"


def _runs(results: Results) -> ResultTable:
    names = results.study.outputs
    shown = [units.for_people(unit_of(name)) for name in names]
    headings = [units.with_unit(label_of(name), unit.name) for name, unit in zip(names, shown, strict=True)]
    values = [
        [_with_ends(results, index, name, unit.size) for name, unit in zip(names, shown, strict=True)]
        for index in range(len(results.runs))
    ]
    if results.limits is not None:
        headings.append(_verdict(results.limits))
        values = [[*row, _level(results, index)] for index, row in enumerate(values)]
    if len(results.runs) == 1:
        return ResultTable("The run", ("quantity", "value"), tuple(zip(headings, values[0], strict=True)))
    rows = [(*(point.label for point in run.points), *row) for run, row in zip(results.runs, values, strict=True)]
    return ResultTable("All runs", (*(axis.meaning for axis in results.axes), *headings), tuple(rows))


def _verdict(limits: LimitSet) -> str:
    return f"verdict, {limits.name}"


def _level(results: Results, index: int) -> str:
    """Verdict on a run in a word."""
    return results.verdict(index).word if index in results.found else "–"


def _with_ends(results: Results, index: int, name: str, size: float) -> str:
    """A value, with the smallest and the largest over places of the bay behind it."""
    low, high = (end / size for end in results.ends(index, name))
    ends = "" if math.isnan(low) else f" ({number(low)} to {number(high)})"
    return number(results.value(index, name) / size) + ends


def _extremes(results: Results) -> ResultTable:
    """Largest and smallest value of every output along the longest axis, for each combination of the others."""
    longest = max(results.axes, key=lambda axis: len(axis.points))
    groups: dict[tuple[str, ...], list[int]] = {}
    for index in range(len(results.runs)):
        rest = tuple(results.point(index, axis.name).label for axis in results.axes if axis is not longest)
        groups.setdefault(rest, []).append(index)
    rows = []
    for rest, indices in groups.items():
        for name in results.study.outputs:
            shown = units.for_people(unit_of(name))
            known = [index for index in indices if not math.isnan(results.value(index, name))]
            if not known:
                continue
            ends = [pick(known, key=lambda index: results.value(index, name)) for pick in (max, min)]
            places = [results.point(end, longest.name).label for end in ends]
            values = [number(results.value(end, name) / shown.size) for end in ends]
            texts = [f"{value} {shown.name} at {place}" for value, place in zip(values, places, strict=True)]
            rows.append((*rest, label_of(name), *texts))
        if results.limits is not None:
            judged = [index for index in indices if index in results.found]
            ends = [pick(judged, key=results.verdict) for pick in (max, min)] if judged else []
            texts = [f"{_level(results, end)} at {results.point(end, longest.name).label}" for end in ends]
            rows += [(*rest, _verdict(results.limits), *texts)] if texts else []
    others = [axis.meaning for axis in results.axes if axis is not longest]
    headings = (*others, "quantity", "largest", "smallest")
    return ResultTable(f"Extremes over the {longest.meaning}", headings, tuple(rows))


def _statistics(results: Results) -> ResultTable:
    """Mean, deviation and quantiles of every output over the draws, for each combination of the other axes."""
    grid = [axis for axis in results.axes if axis.distribution is None]
    groups: dict[tuple[str, ...], list[int]] = {}
    for index in range(len(results.runs)):
        groups.setdefault(tuple(results.point(index, axis.name).label for axis in grid), []).append(index)
    limits, rows = limits_of(results.study), []
    for place, runs in groups.items():
        for name in results.study.outputs:
            shown = units.for_people(unit_of(name))
            values = np.array([results.value(run, name) for run in runs]) / shown.size
            values = values[np.isfinite(values)]
            if not len(values):
                continue
            spread = float(values.std(ddof=1)) if len(values) > 1 else math.nan
            numbers = [float(values.mean()), spread, *np.quantile(values, QUANTILES).tolist()]
            above = [
                f"{100 * np.mean(values > limit / shown.size):.3g} % above {limit / shown.size:g} {shown.name}".rstrip()
                for limit in limits.get(name, [])
            ]
            what = units.with_unit(label_of(name), shown.name)
            rows.append((*place, what, *map(number, numbers), ", ".join(above)))
    quantiles = (f"{100 * share:g} %" for share in QUANTILES)
    headings = (*(axis.meaning for axis in grid), "quantity", "mean", "deviation", *quantiles, "limits")
    columns = headings if limits else headings[:-1]
    return ResultTable("Over the draws", columns, tuple(row[: len(columns)] for row in rows))


def _sensitivities(results: Results) -> Iterator[ResultTable]:
    """Sobol's indices of every output that has them."""
    rows = []
    for name in results.study.outputs:
        found = sobol(results, name)
        if found is not None:
            pairs = zip(results.axes, found.first, found.total, strict=True)
            rows += [
                (label_of(name), axis.meaning, *(f"{share:.2f} ± {half:.2f}" for share, half in (first, total)))
                for axis, first, total in pairs
            ]
    if rows:
        headings = ("quantity", "varied", "first order", "total")
        yield ResultTable("Shares of the variance (Sobol's indices)", headings, tuple(rows))


def _compared(results: Results) -> Iterator[tuple[str, ...]]:
    for index, run in enumerate(results.runs):
        for name in results.study.outputs:
            ours, paper = results.value(index, name), results.published(index, name)
            if not math.isnan(paper):
                shown = units.for_people(unit_of(name))
                difference = f"{100 * (ours / paper - 1):+.1f} %" if paper else "–"
                texts = [f"{number(value / shown.size)} {shown.name}" for value in (ours, paper)]
                yield (run.label, label_of(name), *texts, difference)


def _history(results: Results, index: int) -> dict[str, Any]:
    arrays, scenario = results.found[index].arrays, results.runs[index].scenario
    columns: dict[str, Any] = {DISTANCE: arrays["position"] - scenario.reference_position}
    for place, wheel in enumerate(WHEELS):
        for name, quantity in (("irregularity", "irregularity at y = 0 (m)"), ("forces", "contact force (N)")):
            if name in arrays:
                columns[f"{wheel} {quantity}"] = arrays[name][:, place]
        if "displacements" in arrays:
            columns[f"{wheel} displacement upwards (m)"] = arrays["displacements"][:, 0, place]
            columns[f"{wheel} rail displacement downwards (m)"] = arrays["displacements"][:, 1, place]
    for place, node in enumerate(scenario.output.stress_nodes if "principal" in arrays else ()):
        columns[f"{node} maximum principal stress (Pa)"] = arrays["principal"][:, place]
    return columns


def _pressure(results: Results, index: int, name: str) -> dict[str, Any]:
    """Elements in contact, row by row along the track."""
    arrays = results.found[index].arrays
    pressure = arrays[f"{name}.pressure"]
    at_x, at_y = np.nonzero(pressure > 0)
    return {
        "x from the contact point (m)": arrays[f"{name}.x"][at_x],
        "y (m)": arrays[f"{name}.y"][at_y],
        "pressure (Pa)": pressure[at_x, at_y],
    }
