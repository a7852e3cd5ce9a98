"""Every shipped scenario has the forces and stresses that it had; ``tools/regression.py`` stores them anew."""

import numpy as np
import pytest

from support.shipped_runs import numbers_of, reference
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario

SAME = 1e-6
"""Share of the static load, and of the largest stress: compilers and processors round differently, and no more."""
SLOW = {"rail_roughness"}


def test_all_shipped_scenarios_are_stored() -> None:
    assert set(reference()) == set(shipped.names("scenarios"))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in shipped.names("scenarios")]
)
def test_forces_and_stresses_are_those_that_are_stored(name: str) -> None:
    found, stored = numbers_of(name), reference()[name]
    assert list(found) == list(stored)
    for signal, values in stored.items():
        scale = load_scenario(name).wheel_load if signal.startswith("wheel") else values[0]
        np.testing.assert_allclose(found[signal], values, rtol=0, atol=SAME * scale, err_msg=f"{name}: {signal}")
