"""Refusals are one line of bounded length, whatever is refused."""

import pickle

import pytest

from wheelset_track_sim.errors import LONGEST, InputError


@pytest.mark.parametrize("text", ["speed = 500 m/s: give 5 to 100", "flèche = 0,2 m: é is no digit"])
def test_plain_lines_stay(text):
    assert str(InputError(text)) == text


def test_control_characters_of_what_is_refused_are_escaped():
    assert str(InputError("on = a\nb\x1b[31m\x00: give wheel_1")) == r"on = a\nb\x1b[31m\x00: give wheel_1"


def test_a_long_value_loses_its_middle_and_the_remedy_stays():
    told = str(InputError(f"on = {'A' * 300_000}: give wheel_1"))
    assert LONGEST - 1 <= len(told) <= LONGEST
    assert told.startswith("on = AAA")
    assert told.endswith("A: give wheel_1")
    assert str(InputError(told)) == told


def test_it_can_be_handed_to_another_process():
    assert str(pickle.loads(pickle.dumps(InputError("a\tb")))) == r"a\tb"
