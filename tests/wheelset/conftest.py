from __future__ import annotations

import pytest

from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.wheelset import Wheelset


@pytest.fixture(scope="session")
def x40() -> Wheelset:
    return load_wheelset("x40")


@pytest.fixture(scope="session")
def reduced_x40(x40: Wheelset) -> ReducedWheelset:
    """Built, not from the cache: what is tested is the code as it stands."""
    return build_reduced_wheelset(x40)
