"""Every shipped scenario has the forces and stresses that it had; ``tools/regression.py`` stores them anew."""

import numpy as np
import pytest

from support.shipped_runs import ROWS, numbers_of, reference
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario

TOLERANCES = np.array([5e-4, 5e-4, 1e-6, *[5e-4] * len(ROWS)])
"""Of maximum, minimum, RMS and samples: shares of the static load, or of the largest stress.

Another library of linear algebra reduces the track to other modes: OpenBLAS for another processor shifts samples at an
impact by up to 2.3e-4, and RMS by 1.1e-7. Kernels compiled for another processor shift nothing by more than 2e-10.
"""
SLOW = {"rail_roughness", "rough_wheel", "measured_tread", "polygon", "mixed", "corrugation", "long_wave"}
"""Whose contact is solved in every step, or has a table at every position."""


def test_all_shipped_scenarios_are_stored() -> None:
    assert set(reference()) == set(shipped.names("scenarios"))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in shipped.names("scenarios")]
)
@pytest.mark.slow
def test_forces_and_stresses_are_those_that_are_stored(name: str) -> None:
    found, stored = numbers_of(name), reference()[name]
    assert list(found) == list(stored)
    for signal, values in stored.items():
        scale = load_scenario(name).wheel_load if signal.startswith("wheel") else values[0]
        apart = np.abs(np.subtract(found[signal], values)) / scale
        assert (apart <= TOLERANCES).all(), f"{signal}: {apart.max():.1e} of {scale:g}"
