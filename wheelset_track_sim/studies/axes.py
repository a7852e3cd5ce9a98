"""What a study varies: axes, each with its points; the runs are their product."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..errors import InputError
from ..inputs import amounts, units
from ..inputs.schema import keyed, unknown
from ..runtime.arrays import Real
from ..scenario import suspect
from ..scenario.meaning import meaning_of
from .distributions import Distribution, is_distribution, read_distribution

MOST_POINTS = 10_000

FORMS = (
    "a list of values such as 100 km/h, {start, stop, step}, {values}, {distribution: uniform, normal or lognormal}, "
    "or labels with {key: value} each"
)


@dataclass(frozen=True)
class Point:
    """One place on an axis: what is changed there."""

    label: str
    """As people read it, unit included."""
    value: Any
    """Value of the key, SI; the label if the axis has labels."""
    changes: tuple[tuple[str, Any], ...]
    """Dotted scenario keys with their values."""


@dataclass(frozen=True)
class Axis:
    """A dotted scenario key with its values, or a name with labelled changes of several keys."""

    name: str
    points: tuple[Point, ...]
    meaning: str
    """What is varied, as people read it."""
    unit: str
    """SI unit of the values."""
    distribution: Distribution | None = None
    """What the values are drawn from; the points of all axes with one belong together, draw by draw."""

    def drawn(self, shares: Real) -> Axis:
        """The same axis with a point for each share of probability (n,)."""
        assert self.distribution is not None
        return replace(self, points=_points(self.name, self.distribution.values(shares).tolist(), self.unit))

    @property
    def is_numeric(self) -> bool:
        """Whether its values are numbers, which have an order and a distance."""
        return all(isinstance(point.value, (int, float)) and not isinstance(point.value, bool) for point in self.points)

    @property
    def keys(self) -> set[str]:
        """Scenario keys that it changes."""
        return {key for point in self.points for key, _ in point.changes}

    def point(self, value: Any, where: str) -> Point:
        """Point of a value, in SI or with its unit, or of a label; raises InputError for any other."""
        if isinstance(value, str) and self.is_numeric:
            value = amounts.amount(value, self.unit, where)
        for point in self.points:
            if value in (point.label, point.value) or (self.is_numeric and _close(value, point.value)):
                return point
        known = [str(point.value) for point in self.points]
        raise InputError(unknown("value", f"{where} = {value!r}", str(value), known))


def read_axis(name: str, data: Any, where: str) -> Axis:
    """Axis of a study's ``vary``; raises InputError naming ``where``."""
    meaning, si = meaning_of(name)
    if is_distribution(data):
        return Axis(name, (), meaning, si, read_distribution(data, si, where))
    if isinstance(data, Mapping) and data and all(isinstance(changes, Mapping) for changes in data.values()):
        for label, changes in data.items():
            if not isinstance(label, str | int):
                raise InputError(f"{where} has the label {label!r}, which YAML reads so: put it in quotes")
            for key, value in changes.items():
                suspect(str(key), value, f"{where}.{label}.{key}")
        points = [
            Point(str(label), str(label), tuple(keyed(changes, f"{where}.{label}").items()))
            for label, changes in data.items()
        ]
        return Axis(name, _distinct(points, where), name, "")
    values = _values(data, si, where)
    for value in data if isinstance(data, list) else ():
        suspect(name, value, where)
    si = si if all(isinstance(value, float) for value in values) else ""
    return Axis(name, _distinct(_points(name, values, si), where), meaning, si)


def combinations(axes: Sequence[Axis]) -> Iterator[tuple[Point, ...]]:
    """Points of each run, one on each axis: all combinations of values, the last axis fastest, each with all draws."""
    draws = next((range(len(axis.points)) for axis in axes if axis.distribution), range(1))
    choices = ((None,) if axis.distribution else axis.points for axis in axes)
    for chosen, draw in itertools.product(itertools.product(*choices), draws):
        yield tuple(point or axis.points[draw] for axis, point in zip(axes, chosen, strict=True))


def _points(name: str, values: Iterable[Any], si: str) -> tuple[Point, ...]:
    """Points of the values of a key; those that are numbers are shown in the unit that people read."""
    unit = units.for_people(si)
    shown = (f"{v / unit.size:.6g} {unit.name}".rstrip() if isinstance(v, float) else str(v) for v in values)
    return tuple(Point(label, value, ((name, value),)) for label, value in zip(shown, values, strict=True))


def _values(data: Any, si: str, where: str) -> list[Any]:
    """Values in SI, numbers as floats, of a list or a mapping with a unit."""
    size = 1.0
    if isinstance(data, Mapping):
        for key in data:
            if key not in ("start", "stop", "step", "values", "unit"):
                known = ["start", "stop", "step", "values", "unit"]
                raise InputError(unknown("key", f"{where}.{key}", str(key), known))
        size = _size(data.get("unit", si), si, where)
        data = data.get("values") if "values" in data else _range(data, si, size, where)
    if not isinstance(data, list) or not data:
        raise InputError(f"{where} = {data!r} is not an axis: give {FORMS}")
    found = [_in_si(value, si, size, f"{where}.{index}") for index, value in enumerate(data)]
    # Twelve digits: 0.05 mm times 3 is 0.00015 m, and nothing behind it.
    return [float(f"{value:.12g}") if _is_number(value) else value for value in found]


def _in_si(value: Any, si: str, size: float, where: str) -> Any:
    """A number times the size of its unit, or that of a text with a unit of its own; anything else as it is."""
    if isinstance(value, str) and si:
        return amounts.amount(value, si, where)
    return value * size if _is_number(value) else value


def _range(data: Mapping[str, Any], si: str, size: float, where: str) -> list[float]:
    """Numbers from start to stop, in a unit of the given size."""
    given = {key: _in_si(data.get(key), si, size, f"{where}.{key}") for key in ("start", "stop", "step")}
    for key, value in given.items():
        if not _is_number(value):
            raise InputError(f"{where}.{key} = {data.get(key)!r} is not a number: give {FORMS}")
    start, stop, step = (value / size for value in given.values())
    intervals = (stop - start) / step if step else math.inf
    if not 0 <= intervals < MOST_POINTS:
        raise InputError(
            f"{where} from {start:g} to {stop:g} by {step:g} is not a valid range: give up to {MOST_POINTS} values"
        )
    if not _close(intervals, round(intervals)):
        raise InputError(f"{where}.stop = {stop:g} is not a whole number of steps of {step:g} from {start:g}")
    return [start + index * step for index in range(round(intervals) + 1)]


def _size(name: Any, si: str, where: str) -> float:
    """Size of a unit in SI."""
    size = amounts.size_of(name, si) if isinstance(name, str) else None
    if size is None:
        known = [si, *amounts.others(si)]
        raise InputError(unknown("unit of this quantity", f"{where}.unit = {name!r}", str(name), known))
    return float(size)


def _distinct(points: Iterable[Point], where: str) -> tuple[Point, ...]:
    points = tuple(points)
    labels = [point.label for point in points]
    for label in labels:
        if labels.count(label) > 1:
            raise InputError(f"{where} has {label} more than once: give each value once")
    return points


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _close(value: Any, other: float) -> bool:
    return _is_number(value) and math.isclose(value, other, rel_tol=1e-9, abs_tol=1e-12)
