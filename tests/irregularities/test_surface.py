import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import (
    Breakout,
    Corrugation,
    HeadDefect,
    Patch,
    Roughness,
    line_steps,
    rail_heights,
    tread_heights,
)
from wheelset_track_sim.irregularities.surface import distinct_rows

N_C, DX = 2713, 0.001
Y = np.arange(-20, 21) * 0.001
SIZE_A = Breakout("wheel_1", a=0.010, b=0.008, h=0.001)
HOLLOW = HeadDefect("rail_2", position=0.010, a=0.004, b=0.008, h=0.001)


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


def test_a_rail_has_its_own_at_their_positions_and_repeats():
    shapes = [HOLLOW, dataclasses.replace(HOLLOW, position=0.099), dataclasses.replace(HOLLOW, on="rail_1")]
    heights = rail_heights(shapes, "rail_2", 100, DX, Y).all()
    assert heights.shape == (100, len(Y))
    np.testing.assert_allclose(heights[10 + np.arange(-3, 4), 20], HOLLOW.height(DX * np.arange(-3, 4), 0.0))
    assert heights[99, 20] == heights[10, 20] == -0.001
    assert heights[[96, 2]] == pytest.approx(heights[[7, 13]])
    assert not heights[20:90].any()


def test_rails_are_stored_where_they_are_not_smooth_and_once_where_they_are_the_same():
    long = rail_heights([dataclasses.replace(HOLLOW, position=4000.0)], "rail_2", 5_000_000, DX, Y)
    assert long.row.nbytes == 20_000_000
    assert len(long.heights) == 1 + 4  # the two halves are the same, the rim is zero
    waves = Corrugation("rail_1", wavelength=0.040, amplitude=1e-5)
    assert len(rail_heights([waves], "rail_1", 60_000, DX, Y).heights) <= 42


def test_more_irregular_rail_than_can_be_stored_is_refused():
    with pytest.raises(InputError, match=r"rail_1 is irregular over 300 m: give a line_length .* 200 m at most"):
        rail_heights([Corrugation("rail_1", wavelength=0.041, amplitude=1e-5)], "rail_1", 300_000, DX, np.zeros(1))


@dataclass(frozen=True)
class Ramp:
    type = "ramp"
    on: str = "wheel_1"
    length: int = 10
    value: float = 1e-6

    def patches(self, surface, y):
        yield Patch(5, np.full((self.length, 1), self.value))


def test_longer_than_the_surface_is_refused():
    with pytest.raises(InputError, match=r"2\.714 m long: give one that fits into the 2\.713 m"):
        tread_heights([Ramp(length=N_C + 1)], "wheel_1", N_C, DX, Y)
    with pytest.raises(InputError, match=r"head_defect on rail_2 is 0\.121 m long"):
        rail_heights([dataclasses.replace(HOLLOW, a=0.060)], "rail_2", 100, DX, Y)


def test_heights_that_are_not_finite_are_refused():
    with pytest.raises(InputError, match="not finite"):
        tread_heights([Ramp(value=np.nan)], "wheel_1", N_C, DX, Y)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_heights_that_add_up_beyond_the_limit_are_refused(sign):
    with pytest.raises(InputError, match=r"tread of wheel_1 is 0\.021 m deep where irregularities overlap: .* 0\.02 m"):
        tread_heights([Ramp(value=sign * 0.015), Ramp(value=sign * 0.006)], "wheel_1", N_C, DX, Y)
    assert tread_heights([Ramp(value=0.015), Ramp(value=-0.006)], "wheel_1", N_C, DX, Y).max() == pytest.approx(0.009)


def test_the_line_is_as_long_as_is_told_or_needed():
    assert line_steps([], None, DX) == line_steps([SIZE_A], None, DX) == 1
    assert line_steps([HOLLOW, Roughness("rail_1")], None, DX) == 60_000
    assert line_steps([dataclasses.replace(HOLLOW, position=61.0)], None, DX) == 120_000
    assert line_steps([HOLLOW], 30.0, DX) == 30_000
    with pytest.raises(
        InputError, match=r"rails reach to 99000 m, and rails repeat after at most 5000 m: give positions"
    ):
        line_steps([dataclasses.replace(HOLLOW, position=99_000.0)], None, DX)
    with pytest.raises(InputError, match=r"line_length = 30\.0005 m is not a whole number of steps .* give 30"):
        line_steps([HOLLOW], 30.0005, DX)


@pytest.mark.parametrize(
    ("rows", "kept", "number"),
    [
        ([[1, 2], [0, 0], [1, 2], [0, -0.0], [3, 0]], [[1, 2], [0, 0], [3, 0]], [0, 1, 0, 1, 2]),
        ([[0, 0], [0, 0]], [[0, 0]], [0, 0]),
        ([[5, 1], [5, 2]], [[5, 1], [5, 2]], [0, 1]),
    ],
)
def test_rows_are_numbered_as_they_come(rows, kept, number):
    found, numbers = distinct_rows(np.array(rows, float))
    assert (found.tolist(), numbers.tolist()) == (kept, number)
