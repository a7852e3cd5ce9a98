"""What went into a recorded run, put together from all that its bag says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..bags import Bag
from ..bags.inputs import Input
from ..errors import InputError, RecordingError
from ..inputs.yaml12 import parse
from ..scenario import Scenario, scenario_from
from ..simulation.speed import Stretch


class Change(NamedTuple):
    """A change that had come into force; the first of a run is what it started under."""

    revision: int
    step: int
    scenario: Scenario


@dataclass(frozen=True)
class Recorded:
    """All that is needed to simulate a run again."""

    changes: tuple[Change, ...]
    start: Stretch | None
    """None if the run can be simulated from step 0 on. Otherwise what went in before is unknown, and this is the first
    step that is known: a simulation begins there in steady running, which the run was not in."""


def recorded(bag: Bag) -> Recorded:
    """What went into the run of a bag; RecordingError if the bag does not say, or says what cannot be read."""
    states = bag.states
    inputs = _in_order(
        [*bag.info.inputs, *(Input(state.revision, state.first_step, state.scenario) for state in states)]
    )
    if not inputs:
        raise RecordingError(f"{bag.path} does not say what was simulated: record it with its state topic")
    start = None
    if inputs[0].revision > 0:
        if not states:
            raise RecordingError(
                f"{bag.path} says neither how its run began nor how it went on: record it with its state"
            )
        first = states[0]
        inputs = [found for found in inputs if found.revision >= first.revision]
        start = Stretch(first.first_step, first.time, first.speed, first.speed_set_point)
    return Recorded(tuple(_change(bag, found) for found in inputs), start)


def _in_order(inputs: Sequence[Input]) -> list[Input]:
    """Each revision once, where it is told first: a state is told again after a pause."""
    found: dict[int, Input] = {}
    for each in sorted(inputs, key=lambda each: (each.revision, each.step)):
        found.setdefault(each.revision, each)
    return [*found.values()]


def _change(bag: Bag, of: Input) -> Change:
    try:
        return Change(of.revision, of.step, scenario_from(parse(of.scenario, "it")))
    except InputError as refusal:
        raise RecordingError(
            f"{bag.path}: scenario of revision {of.revision} cannot be used here ({refusal})"
        ) from None
