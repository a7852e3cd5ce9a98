"""When events of a run happen: the step of each on the course of the run, and their order."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import NamedTuple

from ..errors import InputError
from ..scenario import Event, Scenario
from .speed import FAR, NEARLY, Course


class Due(NamedTuple):
    """An event and the step at which it is due."""

    step: int
    event: Event


def step_of(event: Event, scenario: Scenario, course: Course) -> int:
    """Step at which an event is due on a course that is known."""
    if event.step is not None:
        return event.step
    if event.time is not None:
        return course.step_at(event.time)
    if event.distance is not None:
        return math.ceil(event.distance / scenario.step_length - NEARLY)
    return math.ceil((event.turn or 0.0) * scenario.steps_per_revolution - NEARLY)


def next_due(scenario: Scenario, course: Course, events: Iterable[Event] | None = None) -> Due | None:
    """The first of ``events``, or of those of the scenario: of several at a step, the first in the list."""
    coming = scenario.events if events is None else events
    return min((Due(step_of(event, scenario, course), event) for event in coming), key=_step, default=None)


def next_step(scenario: Scenario, course: Course) -> int:
    """Step of the first event to come; ``FAR`` if there is none."""
    found = next_due(scenario, course)
    return FAR if found is None else found.step


def in_order(events: Iterable[Event], scenario: Scenario, course: Course) -> tuple[Event, ...]:
    """Events in the order in which they happen."""

    def order(event: Event) -> tuple[int, float]:
        along = (event.turn or 0.0) * scenario.steps_per_revolution * scenario.step_length
        return step_of(event, scenario, course), event.time or event.distance or along

    return tuple(sorted(events, key=order))


def after(scenario: Scenario, event: Event, step: int, course: Course) -> Scenario:
    """The scenario after an event of it, which happens at ``step``; what is still to come is in its order."""
    changed, following = event.at(scenario, step)
    left = list(scenario.events)
    left.remove(event)
    if following is None:
        return dataclasses.replace(scenario, **changed, events=tuple(left))
    return dataclasses.replace(scenario, **changed, events=in_order([*left, following], scenario, course))


def rehearsed(scenario: Scenario, course: Course) -> Iterable[Scenario]:
    """The scenario, and that after each event in the order of a run to which nothing else happens.

    A growth is complete there at once. Raises InputError for an event that removes irregularities while one grows,
    which is known by its index.
    """
    now, left, growing = dataclasses.replace(scenario, events=()), [*scenario.events], -1
    yield now
    while (due := next_due(now, course, left)) is not None:
        step, event = due
        left.remove(event)
        if step < growing and (event.remove or event.irregularities is not None):
            raise InputError(
                f"{event}: it changes the list of irregularities while one of them grows: let it happen after that, "
                f"from {growing * now.step_length:g} m on"
            )
        if event.grow is not None:
            begun = step * now.step_length if event.grow.since is None else event.grow.since
            growing = max(growing, math.ceil((begun + event.grow.over) / now.step_length - NEARLY))
        now = dataclasses.replace(now, **event.in_the_end(now))
        if event.speed is not None or event.acceleration is not None:
            course = course.redirected(max(step, course.stretches[0].step), now.speed, now.acceleration, now.speed_plan)
        yield now


def _step(due: Due) -> int:
    return due.step
