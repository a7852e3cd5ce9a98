"""The inputs of a recorded run, from everything that its bag holds: as they were, or with settings of another run."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import NamedTuple

from ..bags import Bag
from ..bags.run_info import Input, in_order
from ..errors import InputError, RecordingError, recorded_input
from ..inputs.amounts import whole_number
from ..inputs.schema import confirmed_numbers
from ..inputs.text_files import without_files
from ..inputs.yaml12 import parse
from ..scenario import WHEELS, Scenario, assign, change_of, scenario_from, suspect
from ..scenario.values import first_breakout, quantity_named, values_of, with_values
from ..simulation.speed import Stretch

FIXED = ("name", "step_length", "events")
"""Keys that must stay, so that both runs have samples at the same places, and the same changes."""


class RecordedChange(NamedTuple):
    """A change that had taken effect; the first of a run is its start."""

    revision: int
    step: int
    scenario: Scenario


@dataclass(frozen=True)
class RunInputs:
    """Everything needed to simulate a run again."""

    changes: tuple[RecordedChange, ...]
    start: Stretch | None
    """None if the run can be simulated from step 0 on. Otherwise earlier inputs are unknown, and this is the first
    known step: a simulation begins there in steady running, unlike the recorded run."""


def run_inputs(bag: Bag) -> RunInputs:
    """Inputs of the run in a bag; RecordingError if the bag does not hold them, or they cannot be read."""
    states = bag.states
    inputs = in_order(
        [*bag.info.inputs, *(Input(state.revision, state.first_step, state.scenario) for state in states)]
    )
    if not inputs:
        raise RecordingError(f"{bag.path} does not say what was simulated: record it with its state topic")
    start = None
    if inputs[0].revision > 0:
        if not states:
            raise RecordingError(
                f"{bag.path} describes neither the start of its run nor its changes: record it with its state topic"
            )
        first = states[0]
        inputs = tuple(found for found in inputs if found.revision >= first.revision)
        start = Stretch(first.first_step, first.time, first.speed, first.speed_set_point)
    return RunInputs(tuple(_change(bag, found) for found in inputs), start)


def with_settings(scenarios: Sequence[Scenario], settings: Sequence[str]) -> list[Scenario]:
    """Scenarios of a run with ``key=value`` set in each of them, so that it holds throughout the run.

    A key is that of a scenario (``irregularities.0.h``, ``track.pad.stiffness``) or the name of a parameter of the node
    (``wheel_1.damage.h``, of the first breakout on that wheel). What is set of an irregularity is set in each scenario
    that has this irregularity, and adds none. A ``speed`` ends the speed plan. Raises InputError for a setting that
    cannot be made, or of an irregularity that no scenario has.
    """
    for setting in settings:
        key = setting.partition("=")[0].strip()
        places = [number for number, scenario in enumerate(scenarios) if _has(scenario, key)]
        if not places:
            raise InputError(f"--set {key}: {_missing(scenarios, key)}")
        with nullcontext() if key.startswith("irregularities") else recorded_input():
            scenarios = [_with(scenario, setting) if n in places else scenario for n, scenario in enumerate(scenarios)]
    return [*scenarios]


def _change(bag: Bag, of: Input) -> RecordedChange:
    try:
        data = parse(of.scenario, "it", trusted=False)
        if not isinstance(data, dict):
            raise InputError("it is not a mapping of scenario keys")  # noqa: TRY301
        if bag.info.versions.get("wheelset_track_sim", "").startswith("0.1."):
            data = {"settle_on": "smooth"} | data  # as every run of that version did
        stated = data.get("contact") or {}
        if isinstance(stated, dict):
            data["contact"] = {"exact": True} | stated  # as runs were before there was a filter
        with recorded_input(), without_files():
            # What events have changed is recorded at its step: they do not happen a second time.
            return RecordedChange(of.revision, of.step, dataclasses.replace(scenario_from(data), events=()))
    except InputError as refusal:
        raise RecordingError(
            f"{bag.path}: scenario of revision {of.revision} cannot be used here ({refusal})"
        ) from None


def _has(scenario: Scenario, key: str) -> bool:
    """Whether a scenario has what is set, if that is of an irregularity."""
    name, _, rest = key.partition(".")
    if name in WHEELS and key in values_of(scenario):
        return first_breakout(scenario, name) is not None
    index = whole_number(rest.partition(".")[0])
    return name != "irregularities" or index is None or index < len(scenario.irregularities)


def _missing(scenarios: Sequence[Scenario], key: str) -> str:
    """Why no scenario has the irregularity of a key, and what to do."""
    name = key.partition(".")[0]
    if name not in WHEELS:
        most = max(len(scenario.irregularities) for scenario in scenarios)
        return f"the run has {most} irregularities at most, 0 is the first: give one of them"
    there = {
        f"irregularities.{index} is a {item.type}": None
        for scenario in scenarios
        for index, item in enumerate(scenario.irregularities)
        if item.on == name
    }
    return (
        f"the run has no breakout on {name} ({', '.join(there) or 'which is smooth'}), and a setting adds none: "
        f"set values that are there, or give all irregularities, such as "
        f"irregularities=[{{type: breakout, on: {name}, a: 0.03, b: 0.024, h: 0.001}}]"
    )


def _with(scenario: Scenario, setting: str) -> Scenario:
    key, equals, text = setting.partition("=")
    key = key.strip()
    if key in FIXED:
        raise InputError(f"--set {key}: {key} cannot be set for a recorded run: start a new one with run")
    if equals and key in values_of(scenario):
        value = quantity_named(key).number(f"--set {key}", parse(text, f"the value of --set {key}"))
        if key == "speed":
            scenario = dataclasses.replace(scenario, speed_plan=())
        return with_values(scenario, values_of(scenario) | {key: value})
    data = scenario.to_mapping()
    key, value = change_of(setting)
    suspect(key, value, f"--set {key}")
    assign(data, key, value, "--set ")
    with confirmed_numbers():
        return scenario_from(data)
