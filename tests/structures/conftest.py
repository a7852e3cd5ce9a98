from __future__ import annotations

import pytest

from wheelset_track_sim.structures.reduced_wheelset import ReducedWheelset
from wheelset_track_sim.structures.wheelset import Wheelset, load_wheelset
from wheelset_track_sim.structures.wheelset_reduction import build_reduced_wheelset


@pytest.fixture(scope="session")
def x40() -> Wheelset:
    return load_wheelset("x40")


@pytest.fixture(scope="session")
def reduced_x40(x40: Wheelset) -> ReducedWheelset:
    """Built, not from the cache: what is tested is the code as it stands."""
    return build_reduced_wheelset(x40)
