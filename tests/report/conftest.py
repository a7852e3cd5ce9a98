"""Recordings of plain numbers with the scenarios that come with the package."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.recording import Recording, RunInfo
from wheelset_track_sim.scenario import load_scenario

DX = 1e-3


def recording_of(
    scenario: str = "undamaged",
    changes: Sequence[str] = (),
    *,
    length: float = 6.0,
    spacing: float = 0.6,
    name: str | None = None,
    spikes: Sequence[tuple[float, float]] = (),
    revision_from: int | None = None,
) -> Recording:
    """Run of ``length`` m with 100 kN on wheel 1, 90 kN on wheel 2, uniaxial stresses of 60, 50 and 40 MPa.

    ``spikes`` are (position, force) of single samples of wheel 1; the sample after each has no force.
    """
    what = load_scenario(scenario, changes)
    count = round(length / DX) + 1
    steps = np.arange(count, dtype=np.uint64)
    forces = np.tile([100e3, 90e3], (count, 1))
    for position, force in spikes:
        forces[round(position / DX), 0] = force
        forces[round(position / DX) + 1, 0] = 0.0
    stresses = np.zeros((count, 3, 6))
    stresses[:, :, 1] = 60e6, 50e6, 40e6
    revision = np.zeros(count, dtype=np.uint32)
    if revision_from is not None:
        revision[revision_from:] = 1
    return Recording(
        path=Path("run.mcap"),
        info=RunInfo(name or what.name, what.to_yaml(), what.digest, spacing),
        states=(),
        start_ns=0,
        steps=steps,
        time=steps * what.step_period,
        position=steps * DX,
        speed=np.full(count, what.speed),
        step_period=np.full(count, what.step_period),
        revision=revision,
        forces=forces,
        stresses=stresses,
        nodes=("A1", "B1", "C1"),
    )


@pytest.fixture
def make_recording() -> Callable[..., Recording]:
    return recording_of
