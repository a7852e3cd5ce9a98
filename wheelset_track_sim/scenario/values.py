"""What people set of a scenario, by name: ``speed``, ``wheel_1.damage.h`` and so on.

The node's parameters and ``--set`` of ``resimulate`` have these names.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..errors import InputError
from ..inputs.schema import Quantity, quantity_of
from ..irregularities import Breakout
from .scenario import WHEELS, Scenario

SIZE_C = {"a": 0.030, "b": 0.024, "h": 0.0, "angle": 0.0, "y": 0.0}
"""Damage parameters of a smooth wheel: with a depth ``h`` it is of the paper's size C."""
SCENARIO_NUMBERS = ("speed", "acceleration", "axle_load")
Values = Mapping[str, Any]


def values_of(scenario: Scenario) -> dict[str, float]:
    """Values that describe a scenario; those of damage are of the first breakout on each wheel."""
    values: dict[str, float] = {name: getattr(scenario, name) for name in SCENARIO_NUMBERS}
    for wheel in WHEELS:
        first = first_breakout(scenario, wheel)
        for name, smooth in SIZE_C.items():
            values[f"{wheel}.damage.{name}"] = float(getattr(first, name)) if first else smooth
    return values


def quantity_named(name: str) -> Quantity:
    """Quantity of a value by its name."""
    *damage, last = name.split(".")
    return quantity_of(Breakout if damage else Scenario, last)


def with_values(base: Scenario, values: Values) -> Scenario:
    """``base`` with the values in place: they replace the first breakout on each wheel, or add one.

    A depth of 0 takes it away; further irregularities of ``base`` stay. Raises InputError that names the value.
    """
    irregularities = list(base.irregularities)
    for wheel in WHEELS:
        given = {name: values[f"{wheel}.damage.{name}"] for name in SIZE_C}
        try:
            breakout = Breakout(on=wheel, **given)
        except InputError as refusal:
            raise InputError(f"{wheel}.damage.{refusal}") from None
        first = first_breakout(base, wheel)
        if first == breakout:
            continue
        place = len(irregularities) if first is None else irregularities.index(first)
        irregularities[place : place + 1] = [breakout] if breakout.h > 0 else []
    numbers = {name: values[name] for name in SCENARIO_NUMBERS}
    return dataclasses.replace(base, **numbers, irregularities=tuple(irregularities))


def first_breakout(scenario: Scenario, wheel: str) -> Breakout | None:
    """The breakout of a wheel whose values parameters show; None if it has none."""
    return next((item for item in scenario.irregularities if isinstance(item, Breakout) and item.on == wheel), None)
