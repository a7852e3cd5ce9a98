"""The same scenario with its damage meeting the rail at other places of a bay: peaks depend on it by some percent."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from ..errors import InputError
from ..inputs.schema import quantity_of
from ..samples.block import SampleBlock
from ..scenario import Scenario
from .models import Models
from .simulator import Simulator

MOST = 60
"""Places at most."""


def at_places(scenario: Scenario, places: int) -> tuple[Scenario, ...]:
    """The scenario with angle 0 of the treads first meeting the rail at evenly spaced places of a bay.

    The first one is the scenario's own. Raises InputError for a number of places that is out of range.
    """
    if not 1 <= places <= MOST:
        raise InputError(f"places = {places} is out of range: give 1 to {MOST} places of a bay")
    bay, dx = scenario.track.spacing, scenario.step_length
    farthest = quantity_of(Scenario, "reference_position").high
    found = []
    for number in range(places):
        position = scenario.reference_position + round(number * bay / places / dx) * dx
        found.append(dataclasses.replace(scenario, reference_position=position - bay * (position > farthest)))
    return tuple(found)


def runs(scenarios: tuple[Scenario, ...], models: Models) -> Iterator[Simulator]:
    """Simulators of scenarios that differ in ``reference_position`` alone, on models of one of them."""
    for scenario in scenarios:
        own = dataclasses.replace(models, tables="smooth", tread_origin=scenario.tread_origin)
        yield Simulator(scenario, models=own)


def advanced(simulator: Simulator, steps: int) -> Iterator[SampleBlock]:
    """Blocks of the next ``steps`` samples."""
    end = simulator.next_step + steps
    while simulator.next_step < end:
        yield simulator.advance(end - simulator.next_step)
