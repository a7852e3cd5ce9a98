import numpy as np
import pytest

from wheelset_track_sim.contact.hardness import STEEL, flag, share_from, stated


def test_share_is_of_the_force_and_not_of_the_area():
    pressures = np.array([[0.0, 1e9], [1e9, 6e9]])
    assert share_from(pressures, 2.6e9) == 0.75
    assert share_from(pressures, 6e9) == 0.75
    assert share_from(pressures, 7e9) == 0.0
    assert share_from(np.zeros((2, 2)), 0.0) == 0.0


@pytest.mark.parametrize(
    ("largest", "bound", "words"),
    [
        (2e9, np.inf, ""),
        (3e9, np.inf, "pressure above 2.6 GPa on 50 % of the force"),
        (3e9, 3e9, "pressure at the bound of 3 GPa on 50 % of the force"),
        (3e9, 3.5e9, ""),
        (0.0, np.inf, ""),
    ],
)
def test_flags_are_of_the_bound_or_of_steel(largest, bound, words):
    assert flag(np.array([[largest, largest / 2, largest / 2]]), bound) == words


def test_little_is_not_called_nothing():
    assert flag(np.array([[2.7e9, *[2.5e9] * 200]])) == "pressure above 2.6 GPa on less than 1 % of the force"


def test_stated_hardness():
    assert stated(np.inf) == STEEL == 2.6e9
    assert stated(4e9) == 4e9
