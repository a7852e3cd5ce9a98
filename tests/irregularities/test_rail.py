from typing import NamedTuple

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import rail_heights

Y = np.linspace(-0.01, 0.01, 3)


class Ramp(NamedTuple):
    on: str = "rail_2"
    position: float = 0.010
    half_length: float = 0.003

    def height(self, s, y):
        return 1e-3 * np.asarray(s) + 0 * np.asarray(y)


def test_stands_at_its_position_and_repeats():
    heights = rail_heights([Ramp(), Ramp(position=0.099), Ramp(on="rail_1")], "rail_2", 100, 1e-3, Y)
    assert heights.shape == (100, 3)
    np.testing.assert_allclose(heights[7:14, 1], 1e-6 * np.arange(-3, 4))
    np.testing.assert_allclose(heights[[96, 99, 0, 2], 0], 1e-6 * np.array([-3, 0, 1, 3]), atol=1e-18)
    assert not heights[20:90].any()


def test_longer_than_what_repeats_is_refused():
    with pytest.raises(InputError, match=r"half length = 0\.06 m on rail_2"):
        rail_heights([Ramp(half_length=0.060)], "rail_2", 100, 1e-3, Y)


def test_all_along_covers_every_step():
    heights = rail_heights([Ramp(half_length=np.inf)], "rail_2", 100, 1e-3, Y)
    assert sorted(np.round(heights[:, 0] * 1e6)) == list(range(-50, 50))
