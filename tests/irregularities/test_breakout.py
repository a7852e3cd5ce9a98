import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.schema import read
from wheelset_track_sim.irregularities import TREAD_HALF_WIDTH, Breakout

SIZE_C = Breakout("wheel_1", a=0.030, b=0.024, h=0.002)


def test_height_is_equation_22_as_printed():
    s, y = 0.012, -0.007
    expected = -0.002 / 2 * (1 + np.cos(np.pi * np.sqrt((s / 0.030) ** 2 + (y / 0.024) ** 2)))
    assert SIZE_C.height(s, y) == pytest.approx(expected, rel=1e-12)
    assert SIZE_C.height(0.0, 0.0) == -0.002
    assert SIZE_C.height(0.0151, 0.0) == pytest.approx(-0.001, rel=0.02)


def test_height_is_zero_from_the_rim_on_and_never_positive():
    s, y = np.meshgrid(np.linspace(-0.05, 0.05, 101), np.linspace(-0.05, 0.05, 101))
    height = SIZE_C.height(s, y)
    assert (height <= 0).all()
    assert (height[np.hypot(s / 0.030, y / 0.024) >= 1] == 0).all()
    assert SIZE_C.height(SIZE_C.half_length, 0.0) == 0.0


def test_missing_material_is_that_of_the_closed_form():
    # Integral of Eq. (22) over the ellipse: pi a b h (1/2 - 2/pi^2), near the "order of 20 g" of Section 2.1.
    s, y = np.meshgrid(np.linspace(-0.03, 0.03, 1201), np.linspace(-0.024, 0.024, 1201))
    volume = -SIZE_C.height(s, y).mean() * 0.060 * 0.048 * (1201 / 1200) ** 2
    assert volume == pytest.approx(np.pi * 0.030 * 0.024 * 0.002 * (0.5 - 2 / np.pi**2), rel=1e-4)
    assert 5e-3 < 7850 * volume < 30e-3


def test_lateral_position_moves_the_shape():
    moved = dataclasses.replace(SIZE_C, y=0.01)
    y = np.linspace(-0.03, 0.04, 71)
    np.testing.assert_allclose(moved.height(0.004, y), SIZE_C.height(0.004, y - 0.01), atol=1e-18)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"h": -1e-4}, "h = "),
        ({"h": 0.02}, "h = "),
        ({"a": float("nan")}, "a = nan"),
        ({"b": 0.0}, "b = "),
        ({"a": 0.5}, "a = "),
        ({"angle": float("inf")}, "angle = inf"),
        ({"on": "wheel_3"}, "wheel_3"),
        ({"y": 0.04, "b": 0.03}, "beyond the tread"),
        ({"y": -0.04, "b": 0.03}, "beyond the tread"),
    ],
)
def test_bad_input_is_refused_by_name_in_one_line(change, words):
    with pytest.raises(InputError, match=words) as refusal:
        dataclasses.replace(SIZE_C, **change)
    assert "\n" not in str(refusal.value)
    assert "give" in str(refusal.value)


def test_a_defect_as_wide_as_the_tread_is_accepted():
    assert Breakout("wheel_2", a=0.03, b=TREAD_HALF_WIDTH, h=0.001).b == TREAD_HALF_WIDTH


def test_reads_from_a_scenario_with_its_place_in_messages():
    assert read(Breakout, {"on": "wheel_2", "a": 0.01, "b": 0.008, "h": 0.0003}, "irregularities.0").y == 0.0
    with pytest.raises(InputError, match=r"irregularities\.0\.h"):
        read(Breakout, {"on": "wheel_2", "a": 0.01, "b": 0.008, "h": 1.0}, "irregularities.0")
    with pytest.raises(InputError, match=r"irregularities\.0: .*beyond the tread"):
        read(Breakout, {"on": "wheel_2", "a": 0.01, "b": 0.03, "h": 0.001, "y": 0.04}, "irregularities.0")
