"""The speed over a run: a ramp of limited acceleration as a staircase of levels, each a stretch at one speed.

A step is a length, so a train of constant acceleration ``a`` passes the speed ``v`` at the step
``(v^2 - v_0^2) / (2 a dx)`` of its ramp. The staircase goes from one level to the next where the train passes the mean
of the two, so that its speed is never more than half a level off, and distance and time are those of the train but for
the rounding to whole steps. Levels are multiples of ``LEVEL`` whatever the ramp begins and ends with: the coefficients
of a level serve all ramps through it.

All borders follow from where a ramp begins and from the set points, and from nothing else: however the run is cut into
blocks, they are at the same steps.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from ..scenario import Scenario, SetPoint

LEVEL = 0.5
"""Distance of the levels, m/s. At a border the force changes by 3 N, of 98 kN and of a ripple of 1 to 7 kN at the
sleepers. Against a staircase sixteen times as fine the force differs by 0.1 % of the static load (RMS) and 0.4 % (most)
where it changes most with the speed, at 100 km/h, and by a third of that elsewhere."""

NEARLY = 1e-6
"""Steps by which a time may be rounded."""
FAR = 2**62
"""A step that no run comes to."""


@dataclass(frozen=True)
class Stretch:
    """Steps at one speed, up to the next stretch."""

    step: int
    """The first."""
    time: float
    """Of the first step since step 0, s."""
    speed: float
    """m/s"""
    set_point: float
    """Speed that is approached, m/s."""

    def time_of(self, step: int, dx: float) -> float:
        """Time of one of its steps since step 0, s; ``dx`` is the length of a step, m."""
        return self.time + (step - self.step) * (dx / self.speed)

    def step_at(self, time: float, dx: float) -> int:
        """First of its steps, if it went on for ever, at or after a time since step 0, s."""
        return self.step + max(0, math.ceil((time - self.time) * self.speed / dx - NEARLY))


@dataclass(frozen=True)
class Course:
    """All stretches of a run that are known, the current one first; the last one goes on for ever."""

    stretches: tuple[Stretch, ...]
    dx: float
    """Length of a step, m."""

    def at(self, step: int) -> Stretch:
        """The stretch of a step; the first one for all steps before it."""
        return self.stretches[max(0, bisect_right(self.stretches, step, key=_first) - 1)]

    def time_of(self, step: int) -> float:
        """Time of a step since step 0, s."""
        return self.at(step).time_of(step, self.dx)

    def step_at(self, time: float) -> int:
        """First step at or after a time since step 0, s; the first step of all for earlier times."""
        for on, following in pairwise(self.stretches):
            if (step := on.step_at(time, self.dx)) <= following.step:
                return step
        return self.stretches[-1].step_at(time, self.dx)

    def border(self, step: int) -> int:
        """First step behind ``step`` with another speed or set point; ``FAR`` if there is none."""
        ahead = self.ahead(step)
        return ahead[0].step if ahead else FAR

    def ahead(self, step: int) -> tuple[Stretch, ...]:
        """Stretches that begin behind ``step``."""
        return self.stretches[bisect_right(self.stretches, step, key=_first) :]

    def redirected(self, step: int, set_point: float, acceleration: float, plan: Sequence[SetPoint] = ()) -> Course:
        """From ``step`` on to another ``set_point`` (m/s) at ``acceleration`` (m/s^2), then to those of a ``plan``.

        Each ramp begins with the speed in force. Set points of the plan that are due before the time of ``step`` are
        left out; each of the others is approached from the first step at or behind its time on.
        """
        now = self.at(step)
        start = Stretch(step, now.time_of(step, self.dx), now.speed, set_point)
        found = [start, *ramp(start, acceleration, self.dx)]
        for point in plan:
            if point.time < start.time:
                continue
            while len(found) > 1 and found[-1].time > point.time:
                found.pop()
            on = found[-1]
            due = on.step + math.ceil((point.time - on.time) * on.speed / self.dx)
            start = Stretch(due, on.time_of(due, self.dx), on.speed, point.speed)
            if due == on.step:
                found.pop()
            found += [start, *ramp(start, acceleration, self.dx)]
        return Course(tuple(found), self.dx)


def course_of(scenario: Scenario, start: Stretch | None = None) -> Course:
    """The course of a run that ``start``s at step 0, or elsewhere, and to which nothing else happens."""
    begin = start or Stretch(0, 0.0, scenario.speed, scenario.speed)
    course = Course((begin,), scenario.step_length)
    return course.redirected(begin.step, begin.set_point, scenario.acceleration, scenario.speed_plan)


def ramp(start: Stretch, acceleration: float, dx: float) -> Iterator[Stretch]:
    """Stretches behind ``start``, from its speed to its set point, at ``acceleration`` m/s^2 up or down."""
    on = start
    borders: dict[int, float] = {}
    for before, after in pairwise([start.speed, *levels(start.speed, start.set_point)]):
        mean = (before + after) / 2
        way = abs(mean**2 - start.speed**2) / (2 * acceleration)
        borders[start.step + max(1, math.ceil(way / dx))] = after  # of several levels at a step the last one
    for step, speed in borders.items():
        on = Stretch(step, on.time_of(step, dx), speed, start.set_point)
        yield on


def levels(speed: float, set_point: float) -> list[float]:
    """Speeds of a staircase from ``speed`` (not one of them) to ``set_point`` (the last one), m/s."""
    if speed == set_point:
        return []
    low, high = sorted((speed, set_point))
    between = [level * LEVEL for level in range(math.floor(low / LEVEL) + 1, math.ceil(high / LEVEL))]
    return [*(between if speed < set_point else reversed(between)), set_point]


def _first(stretch: Stretch) -> int:
    return stretch.step
