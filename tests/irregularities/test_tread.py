import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Breakout, tread_heights

N_C, DX = 2713, 0.001
Y = np.arange(-20, 21) * 0.001
SIZE_A = Breakout("wheel_1", a=0.010, b=0.008, h=0.001)


def test_centre_lies_on_a_step_and_the_shape_is_sampled_from_there():
    heights = tread_heights([dataclasses.replace(SIZE_A, angle=1.0)], "wheel_1", N_C, DX, Y)
    centre = round(N_C / (2 * np.pi))
    assert heights.shape == (N_C, len(Y))
    assert heights[centre, 20] == -0.001
    np.testing.assert_allclose(heights[centre + 4], SIZE_A.height(0.004, Y), atol=1e-18)
    assert np.flatnonzero(heights.any(axis=1)).tolist() == list(range(centre - 9, centre + 10))


@given(st.floats(-6.28, 6.28))
def test_wraps_around_the_circumference(angle):
    at_zero = tread_heights([SIZE_A], "wheel_1", N_C, DX, Y)
    turned = tread_heights([dataclasses.replace(SIZE_A, angle=angle)], "wheel_1", N_C, DX, Y)
    assert (turned == np.roll(at_zero, round(angle / (2 * np.pi) * N_C), axis=0)).all()


def test_each_wheel_has_its_own_and_several_superpose():
    other = dataclasses.replace(SIZE_A, on="wheel_2")
    overlapping = dataclasses.replace(SIZE_A, angle=0.02, y=0.003)
    one = tread_heights([SIZE_A, other], "wheel_1", N_C, DX, Y)
    assert (one == tread_heights([SIZE_A], "wheel_1", N_C, DX, Y)).all()
    both = tread_heights([SIZE_A, overlapping], "wheel_1", N_C, DX, Y)
    np.testing.assert_allclose(both, one + tread_heights([overlapping], "wheel_1", N_C, DX, Y), atol=1e-18)


@dataclass(frozen=True)
class Endless:
    on: str = "wheel_1"
    angle: float = 0.0
    half_length: float = 2.0

    def height(self, s, y):
        return s + y


def test_longer_than_the_circumference_is_refused():
    with pytest.raises(InputError, match="longer than half of it"):
        tread_heights([Endless()], "wheel_1", N_C, DX, Y)


def test_heights_that_are_not_finite_are_refused():
    class Broken(Endless):
        def height(self, s, y):
            return s + y + np.nan

    with pytest.raises(InputError, match="not finite"):
        tread_heights([Broken(half_length=0.01)], "wheel_1", N_C, DX, Y)


def test_depths_that_add_up_beyond_the_limit_are_refused():
    deep = dataclasses.replace(SIZE_A, h=0.010)
    assert tread_heights([deep, deep], "wheel_1", N_C, DX, Y).min() == -0.020
    with pytest.raises(InputError, match=r"tread of wheel_1 is 0\.021 m deep where irregularities overlap: .* 0\.02 m"):
        tread_heights([deep, deep, SIZE_A], "wheel_1", N_C, DX, Y)
