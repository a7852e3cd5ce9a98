"""Events over a run: at a time, step, distance or turn, something changes.

An event turns the scenario in force into the next one, as a change by a service does. What has not happened yet stands
in the ``events`` of a scenario, so that each scenario of a run says what is still to come.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

from ..errors import InputError
from ..inputs.amounts import amount
from ..inputs.dotted import entry, put
from ..inputs.schema import check, confirmed_numbers, parsed, plain, quantity, read, unknown
from ..irregularities import Irregularity, plain_irregularities, read_irregularities
from ..irregularities.kinds import read_irregularity
from ..irregularities.listing import list_of, locate_files
from ..irregularities.surface import RAILS, WHEELS
from .loads import TORQUES
from .quantities import kinds, quantity_within

if TYPE_CHECKING:
    from ..sensors.kinds import Sensor
    from .scenario import Scenario

MOST = 500
"""Events of a scenario at most."""
FARTHEST, LAST_STEP = 1e9, 1e13
"""Distance, m, and step of an event at most."""
WHEN = ("time", "step", "distance", "turn")
"""Keys that say when an event happens."""
USUAL_SPEED = (5.0, 65.0)
"""Speeds that are not doubted when they are given without a unit, m/s: up to 234 km/h."""
USUAL_LOAD = (4e4, 4e5)
"""The same for axle loads, N."""
OF_SURFACES = ("irregularities", "replace", "remove", "add", "set", "grow")
OF_NODE = ("record", "snapshot")
"""Keys that concern the recording of a node, not the simulation."""
LIST = "irregularities"
NOISES = ("noise", "drift")
"""Keys of a sensor that can change."""


@dataclass(frozen=True)
class Growth:
    """A value of an irregularity that grows over distance by a power law, in steps.

    At the distance ``x`` from where it begins it is ``start + (to - start) (x / over) ** exponent``; it takes the
    values of that law at ``over / steps``, ``2 over / steps`` and so on.
    """

    key: str
    """Dotted, such as ``irregularities.0.h``."""
    to: float
    """Value that it reaches, SI."""
    over: float = quantity("m", 0.1, FARTHEST, "the distance over which it grows")
    steps: int = quantity("", 1, 1000, "the number of steps in which it grows", default=10)
    exponent: float = quantity("", 0.1, 10.0, "the exponent of the law of growth", default=1.0)
    since: float | None = quantity("m", 0.0, FARTHEST, "the distance at which it has begun", default=None)
    """None before it begins; the next three are of growth that is under way."""
    start: float = 0.0
    """Value at its beginning, SI."""
    done: int = quantity("", 0, 1000, "the number of steps that are done", default=0)

    def __post_init__(self) -> None:
        check(self)
        _check_key(self.key, "key")

    @property
    def value(self) -> float:
        """Value after the steps that are done, SI."""
        if self.done >= self.steps:
            return self.to
        share: float = (self.done / self.steps) ** self.exponent
        return self.start + (self.to - self.start) * share

    @property
    def next_distance(self) -> float:
        """Distance since the start of the run at which the next step is due, m."""
        return (self.since or 0.0) + self.over * (self.done + 1) / self.steps


def _read_list(data: Any, where: str) -> tuple[Irregularity, ...] | None:
    return None if data is None else read_irregularities(data, where)


def _plain_list(items: Sequence[Irregularity] | None) -> Any:
    return None if items is None else plain_irregularities(items)


def _read_replaced(data: Any, where: str) -> tuple[tuple[int, Irregularity], ...]:
    if not isinstance(data, dict) or not all(type(key) is int and key >= 0 for key in data):
        raise InputError(f"{where} is not a mapping of indices (0 is the first) to irregularities: give {{0: {{...}}}}")
    return tuple((index, read_irregularity(item, f"{where}.{index}")) for index, item in data.items())


def _plain_replaced(items: Iterable[tuple[int, Irregularity]]) -> Any:
    return {index: plain_irregularities([item])[0] for index, item in items}


def _read_set(data: Any, where: str) -> tuple[tuple[str, Any], ...]:
    if not isinstance(data, dict):
        raise InputError(f"{where} = {data!r} is not a mapping: give {{irregularities.0.h: 0.001}} or such")
    for key in data:
        _check_key(key, where)
    return tuple((key, _si(key, value, f"{where}.{key}")) for key, value in data.items())


def _read_noises(data: Any, where: str) -> tuple[tuple[str, tuple[tuple[str, Any], ...]], ...]:
    if not isinstance(data, dict) or not all(isinstance(each, dict) and each for each in data.values()):
        raise InputError(
            f"{where} is not a mapping of topics: give {{axle_box_acceleration: {{noise: 1 m/s^2}}}} or such"
        )
    for topic, values in data.items():
        for key in values:
            if key not in NOISES:
                raise InputError(unknown(f"key of {where}.{topic} that can change", repr(key), str(key), NOISES))
    return tuple((topic, tuple(values.items())) for topic, values in data.items())


def _plain_noises(items: Iterable[tuple[str, tuple[tuple[str, Any], ...]]]) -> Any:
    return {topic: dict(values) for topic, values in items}


def _read_growth(data: Any, where: str) -> Growth | None:
    if isinstance(data, dict) and isinstance(data.get("to"), str) and isinstance(data.get("key"), str):
        data = {**data, "to": _si(data["key"], data["to"], f"{where}.to")}
    return data if data is None or isinstance(data, Growth) else read(Growth, data, where)


def _plain_growth(growth: Growth | None) -> Any:
    return None if growth is None else _without_defaults(growth)


def _si(key: str, value: Any, where: str) -> Any:
    """SI number of a text with a unit; what is none is returned as it is."""
    found = quantity_within(kinds(), key.split(".")[2:]) if isinstance(value, str) else None
    return value if found is None else amount(value, found.unit, where)


def _check_key(key: Any, where: str) -> None:
    parts = key.split(".") if isinstance(key, str) else []
    if len(parts) < 3 or parts[0] != LIST or not parts[1].isdecimal():
        raise InputError(
            f"{where} = {key!r} is not a value of an irregularity: give its dotted key, such as irregularities.0.h, "
            "where 0 is the first"
        )


@dataclass(frozen=True)
class Event:
    """Something that changes once, at a time, step, distance or turn since step 0. SI units."""

    time: float | None = quantity("s", 0.0, 1e6, "the time of an event since step 0", default=None)
    step: int | None = quantity("", 0, LAST_STEP, "the step of an event", default=None)
    distance: float | None = quantity("m", 0.0, FARTHEST, "the distance of an event from step 0", default=None)
    turn: float | None = quantity("", 0.0, FARTHEST, "the turns of the wheel from step 0 to an event", default=None)

    speed: float | None = quantity("m/s", 5.0, 100.0, "the speed that is approached", usual=USUAL_SPEED, default=None)
    """Ends a speed plan."""
    acceleration: float | None = quantity("m/s^2", 0.01, 10.0, "the acceleration to a set point", default=None)
    axle_load: float | None = quantity(
        "N", 2e4, 4e5, "the static load on both wheels together", usual=USUAL_LOAD, default=None
    )
    torque: float | None = quantity("N m", -2e5, 2e5, "the torque that is approached", usual=TORQUES, default=None)
    """Ends a torque plan."""

    irregularities: tuple[Irregularity, ...] | None = parsed(_read_list, _plain_list, default=None)
    """All of treads and rails, instead of those in force."""
    set: tuple[tuple[str, Any], ...] = parsed(_read_set, dict, default=())
    """Values by dotted key, in files as a mapping; indices of this and the next two are of the list in force."""
    replace: tuple[tuple[int, Irregularity], ...] = parsed(_read_replaced, _plain_replaced, default=())
    """By index, in files as a mapping."""
    remove: tuple[int | str, ...] = ()
    """Indices, or names of surfaces from which all is removed."""
    add: tuple[Irregularity, ...] = parsed(_read_list, _plain_list, default=())
    """Appended to the list."""
    grow: Growth | None = parsed(_read_growth, _plain_growth, default=None)
    """Begins; its index is of the list after the event."""

    sensors: tuple[tuple[str, tuple[tuple[str, Any], ...]], ...] = parsed(_read_noises, _plain_noises, default=())
    """Noise and drift of sensors by topic, in files as a mapping of mappings."""

    record: Literal["start", "stop"] | None = None
    """Of a node."""
    snapshot: bool = False
    """Of a node in snapshot mode."""

    def __post_init__(self) -> None:
        check(self)
        given = [name for name in WHEN if getattr(self, name) is not None]
        if len(given) != 1:
            raise InputError(f"it has {' and '.join(given) or 'no time'}: give one of {', '.join(WHEN)}")
        if self.irregularities is not None and (self.replace or self.remove or self.set):
            raise InputError("irregularities replaces all of them: give set, replace and remove in another event")
        known = (*WHEELS, *RAILS)
        for item in self.remove:
            if item not in known if isinstance(item, str) else item < 0:
                raise InputError(f"remove = {item!r} is not an index (0 is the first) or one of {', '.join(known)}")
        if all(getattr(self, field.name) == field.default for field in fields(self) if field.name not in WHEN):
            raise InputError(f"it changes nothing: give {', '.join(name for name in _names() if name not in WHEN)}")

    def __str__(self) -> str:
        unit = {"time": " s", "distance": " m"}
        when = next(name for name in WHEN if getattr(self, name) is not None)
        return f"event at {when} {getattr(self, when):.10g}{unit.get(when, '')}"

    @property
    def what(self) -> tuple[str, ...]:
        """Keys of what it changes."""
        return tuple(name for name in _names() if name not in WHEN and getattr(self, name) != _default(name))

    @property
    def brought(self) -> tuple[Irregularity, ...]:
        """Irregularities that it brings."""
        return (*(self.irregularities or ()), *(item for _, item in self.replace), *self.add)

    def at(self, scenario: Scenario, step: int) -> tuple[dict[str, Any], Event | None]:
        """What happens at ``step``: the keys that change in ``scenario``, and the event that follows.

        A growth is followed by its next step. Raises InputError for an irregularity that is not there, or a value that
        cannot be.
        """
        growth = self.grow
        if growth is not None and growth.since is not None:
            growth = replace(growth, done=growth.done + 1)
            changed = self._changed(scenario, ((growth.key, growth.value),))
        else:
            changed = self._changed(scenario)
            if growth is not None:
                listed = changed.get(LIST, scenario.irregularities)
                growth = replace(growth, since=step * scenario.step_length, start=_number(growth.key, listed))
        if growth is None or growth.done >= growth.steps:
            return changed, None
        return changed, Event(distance=growth.next_distance, grow=growth)

    def in_the_end(self, scenario: Scenario) -> dict[str, Any]:
        """Keys that change in ``scenario``, with a growth complete; raises InputError as ``at``."""
        changed = self._changed(scenario)
        if self.grow is None:
            return changed
        listed = changed.get(LIST, scenario.irregularities)
        _number(self.grow.key, listed)
        return {**changed, LIST: _with_values(listed, ((self.grow.key, self.grow.to),))}

    def _changed(self, scenario: Scenario, values: tuple[tuple[str, Any], ...] = ()) -> dict[str, Any]:
        changed: dict[str, Any] = {
            name: value for name in ("speed", "acceleration", "axle_load") if (value := getattr(self, name)) is not None
        }
        if self.speed is not None:
            changed["speed_plan"] = ()
        if self.torque is not None:
            changed["loads"] = replace(scenario.loads, torque=self.torque, torque_plan=())
        if self.sensors:
            changed["sensors"] = _with_noises(scenario.sensors, self.sensors)
        if self.irregularities is not None:
            return {**changed, LIST: (*self.irregularities, *self.add)}
        listed = [*_with_values(scenario.irregularities, (*self.set, *values))]
        for index, item in self.replace:
            _check_index(index, listed, f"replace.{index}")
            listed[index] = item
        removed = self._removed(listed)
        listed = [item for index, item in enumerate(listed) if index not in removed]
        return {**changed, LIST: (*listed, *self.add)}

    def _removed(self, listed: Sequence[Irregularity]) -> frozenset[int]:
        found: list[int] = []
        for item in self.remove:
            if isinstance(item, int):
                _check_index(item, listed, f"remove = {item}")
                found.append(item)
                continue
            there = [index for index, each in enumerate(listed) if each.on == item]
            if not there:
                raise InputError(f"remove = {item}: nothing is on {item} then, leave it out")
            found += there
        return frozenset(found)


def read_events(data: Any, where: str) -> tuple[Event, ...]:
    """Events from a list of mappings; raises InputError."""
    if isinstance(data, str) or not isinstance(data, Sequence):
        raise InputError(f"{where} = {data!r} is not a list: put its entries in brackets, or a dash before each")
    if len(data) > MOST:
        raise InputError(f"{where} has {len(data)} entries: give at most {MOST}")
    return tuple(
        item if isinstance(item, Event) else read(Event, item, f"{where}.{index}") for index, item in enumerate(data)
    )


def plain_brought(event: Any) -> list[Any]:
    """Plain irregularities that a plain event brings."""
    if not isinstance(event, dict):
        return []
    lists = [event[key] for key in ("irregularities", "add") if isinstance(event.get(key), list)]
    replaced = event.get("replace")
    return [item for each in lists for item in each] + ([*replaced.values()] if isinstance(replaced, dict) else [])


def listed_events(text: str, located: Callable[[str], str]) -> tuple[Event, ...]:
    """Events of a YAML text that comes over a network; an empty one has none.

    ``located`` finds the files that its irregularities name, or refuses them. Raises InputError that names the entry.
    """
    data = list_of(text, "events")
    for item in data:
        locate_files(plain_brought(item), located)
    return read_events(data, "events")


def plain_events(events: Iterable[Event]) -> list[Any]:
    """Plain mappings from which ``read_events`` makes equal events."""
    return [_without_defaults(event) for event in events]


def check_events(scenario: Scenario) -> None:
    """Raise InputError for events of ``scenario`` that are not in order, or cannot happen in the order of the list."""
    for kinds_of_time in (("time",), WHEN[1:]):
        placed = [
            (index, value, name)
            for index, event in enumerate(scenario.events)
            for name in kinds_of_time
            if (value := getattr(event, name)) is not None
        ]
        for (before, earlier, name_before), (after, later, name) in pairwise(placed):
            if _along(later, name, scenario) < _along(earlier, name_before, scenario) - 1e-9:
                raise InputError(
                    f"events.{after}.{name} = {later:.10g} comes before events.{before}.{name_before} = "
                    f"{earlier:.10g}: list events in the order in which they happen"
                )
    now = replace(scenario, events=())
    for index, event in enumerate(scenario.events):
        try:
            following = replace(now, **event.in_the_end(now))
            now.check_change(following)
        except InputError as refusal:
            raise InputError(f"events.{index}: {refusal}") from None
        now = following


def _along(value: float, name: str, scenario: Scenario) -> float:
    """Place of an event along the track, m, or its time, s."""
    turn = scenario.steps_per_revolution * scenario.step_length
    return value * {"step": scenario.step_length, "turn": turn}.get(name, 1.0)


def _with_values(listed: tuple[Irregularity, ...], values: Iterable[tuple[str, Any]]) -> tuple[Irregularity, ...]:
    """Irregularities with values by dotted key; each is read again when all of its values are in place."""
    touched: dict[int, Any] = {}
    for key, value in values:
        _, index, rest = key.split(".", 2)
        _check_index(int(index), listed, key)
        if int(index) not in touched:
            touched[int(index)] = plain_irregularities([listed[int(index)]])[0]
        entry(touched[int(index)], rest, f"{LIST}.{index}.")
        put(touched[int(index)], rest, value, f"{LIST}.{index}.")
    with confirmed_numbers():
        found = {index: read_irregularity(item, f"{LIST}.{index}") for index, item in touched.items()}
    return tuple(found.get(index, item) for index, item in enumerate(listed))


def _with_noises(
    sensors: Sequence[Sensor], noises: Iterable[tuple[str, tuple[tuple[str, Any], ...]]]
) -> tuple[Sensor, ...]:
    """Sensors with other noise and drift, by topic."""
    found = {sensor.topic: sensor for sensor in sensors}
    for topic, values in noises:
        if topic not in found:
            raise InputError(unknown("topic of a sensor of the scenario", f"sensors.{topic}", topic, [*found]))
        where, unit = f"sensors.{topic}", found[topic].unit
        numbers = {
            key: amount(value, unit, f"{where}.{key}") if isinstance(value, str) else value for key, value in values
        }
        try:
            found[topic] = replace(found[topic], **numbers)  # type: ignore[arg-type]  # whatever the kind, its numbers
        except InputError as refusal:
            raise InputError(f"{where}: {refusal}") from None
    return tuple(found.values())


def _number(key: str, listed: Sequence[Irregularity]) -> float:
    """Number of an irregularity by its dotted key; raises InputError if it is none."""
    _, index, rest = key.split(".", 2)
    _check_index(int(index), listed, f"grow.key = {key}")
    value = entry(plain_irregularities([listed[int(index)]])[0], rest, f"{LIST}.{index}.")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"grow.key = {key} is not a number: give a value that grows, such as {LIST}.0.h")
    return float(value)


def _check_index(index: int, listed: Sequence[Any], where: str) -> None:
    if index >= len(listed):
        there = f"irregularities 0 to {len(listed) - 1}" if listed else "no irregularities"
        raise InputError(f"{where}: the run has {there} then: give an index of them")


def _without_defaults(item: Event | Growth) -> dict[str, Any]:
    return {
        field.name: field.metadata.get("writer", plain)(value)
        for field in fields(item)
        if (value := getattr(item, field.name)) != field.default
    }


def _names() -> list[str]:
    return [field.name for field in fields(Event)]


def _default(name: str) -> Any:
    return next(field.default for field in fields(Event) if field.name == name)
