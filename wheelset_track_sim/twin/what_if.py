"""Recorded changes with something set that holds throughout the run."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from ..errors import InputError
from ..inputs.yaml12 import parse
from ..scenario import Scenario, override, scenario_from
from ..scenario.values import values_of, with_values

FIXED = ("name", "step_length")
"""Keys without which samples do not stand where the recorded ones do."""


def with_settings(scenarios: Sequence[Scenario], settings: Sequence[str]) -> list[Scenario]:
    """Scenarios with ``key=value`` set in each of them, whatever the run changed it to.

    A key is that of a scenario (``irregularities.0.h``, ``track.pad.stiffness``) or has the name of the node's
    parameter (``wheel_1.damage.h``). An irregularity is set wherever a scenario has as many. A ``speed`` ends the speed
    plan. Raises InputError for a setting that cannot be made, or nowhere.
    """
    for setting in settings:
        key = setting.partition("=")[0]
        places = [number for number, scenario in enumerate(scenarios) if _has(scenario, key)]
        if not places:
            most = max(len(scenario.irregularities) for scenario in scenarios)
            raise InputError(
                f"--set {key}: the run has {most} irregularities at most, 0 is the first: give one of them"
            )
        scenarios = [_with(scenario, setting) if n in places else scenario for n, scenario in enumerate(scenarios)]
    return [*scenarios]


def _has(scenario: Scenario, key: str) -> bool:
    name, _, rest = key.partition(".")
    index = rest.partition(".")[0]
    return name != "irregularities" or not index.isdigit() or int(index) < len(scenario.irregularities)


def _with(scenario: Scenario, setting: str) -> Scenario:
    key, equals, text = setting.partition("=")
    if key in FIXED:
        raise InputError(f"--set {key}: {key} cannot be set for a recorded run: simulate it anew with run")
    if equals and key in values_of(scenario):
        value: Any = parse(text, f"the value of --set {key}")
        if key == "speed":
            scenario = dataclasses.replace(scenario, speed_plan=())
        return with_values(scenario, values_of(scenario) | {key: value})
    data = scenario.to_mapping()
    override(data, setting)
    return scenario_from(data)
