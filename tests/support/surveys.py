"""Runs of plain numbers with the scenarios that come with the package, surveyed block by block."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from wheelset_track_sim.bags import BagWriter, RunInfo, State
from wheelset_track_sim.bags.tread_damage import damage_fields
from wheelset_track_sim.report.survey import Survey, survey_of
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.impacts import ImpactSettings
from wheelset_track_sim.scenario import Scenario, load_scenario

DX = 1e-3
NODES = ("A1", "B1", "C1")


def state(what: Scenario, step: int, time: float, revision: int) -> State:
    return State(
        first_step=step,
        time=time,
        step_period=what.step_period,
        speed=what.speed,
        speed_set_point=what.speed,
        position=step * DX,
        revision=revision,
        axle_load=what.axle_load,
        damage=damage_fields(what.irregularities),
        scenario_name=what.name,
        scenario=what.to_yaml(),
        digest=what.digest,
    )


def events(
    what: Scenario,
    length: float,
    spikes: Sequence[tuple[float, float]],
    wheel: int,
    revisions: Sequence[tuple[int, Scenario]],
    chunk: int,
) -> Iterator[SampleBlock | State]:
    count = round(length / DX) + 1
    forces = np.tile([100e3, 90e3], (count, 1))
    for position, force in spikes:
        forces[round(position / DX), wheel] = force
        forces[round(position / DX) + 1, wheel] = 0.0
    stresses = np.zeros((count, len(NODES), 6))
    stresses[:, :, 1] = 60e6, 50e6, 40e6
    time = 0.0
    plan = [(0, what), *revisions, (count, what)]
    for revision, ((first, now), (end, _)) in enumerate(pairwise(plan)):
        yield state(now, first, time, revision)
        for start in range(first, end, chunk):
            part = slice(start, min(start + chunk, end))
            yield SampleBlock(
                first_step=start,
                time=time,
                step_period=DX / now.speed,
                speed=now.speed,
                position=start * DX,
                revision=revision,
                forces=forces[part].copy(),
                stresses=stresses[part].copy(),
                nodes=NODES,
            )
            time += (part.stop - start) * DX / now.speed


def survey_of_numbers(
    scenario: str = "undamaged",
    changes: Sequence[str] = (),
    *,
    length: float = 6.0,
    spacing: float = 0.6,
    name: str | None = None,
    spikes: Sequence[tuple[float, float]] = (),
    wheel: int = 0,
    revisions: Sequence[tuple[int, Sequence[str]]] = (),
    chunk: int = 1389,
    threshold: float = 200e3,
    known: bool = True,
) -> Survey:
    """Run of ``length`` m with 100 kN on wheel 1, 90 kN on wheel 2, uniaxial stresses of 60, 50 and 40 MPa.

    ``spikes`` are (position, force) of single samples of a wheel; the sample after each has no force. ``revisions``
    are (first step, changes of the scenario).
    """
    what = load_scenario(scenario, changes)
    later = [(step, load_scenario(scenario, [*changes, *more])) for step, more in revisions]
    info = RunInfo(name or what.name, what.to_yaml() if known else "", what.digest if known else "", spacing)
    found = events(what, length, spikes, wheel, later, chunk)
    kept = found if known else (event for event in found if isinstance(event, SampleBlock))
    return survey_of(kept, info, 0, Path("run.mcap"), ImpactSettings(threshold))


def bag_of_numbers(path: Path, scenario: str, length: float, spikes: Sequence[tuple[float, float]]) -> Path:
    """Bag of the same."""
    what = load_scenario(scenario)
    info = RunInfo(what.name, what.to_yaml(), what.digest, 0.6)
    with BagWriter(path, info, start_ns=0) as writer:
        for event in events(what, length, spikes, 0, (), 1389):
            if isinstance(event, State):
                writer.write_state(event)
            else:
                writer.write(event)
    return path
