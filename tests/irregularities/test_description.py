"""Irregularities in words."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.irregularities.description import description_of
from wheelset_track_sim.scenario import load_scenario


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (
            {"type": "flat", "on": "wheel_1", "length": 0.06, "worn_length": 0.12, "angle": 0.5},
            "flat on wheel_1: length 60 mm, worn length 120 mm, angle 28.6479°",
        ),
        ({"type": "flat", "on": "wheel_2", "length": 0.06, "worn_length": None}, "flat on wheel_2: length 60 mm"),
        (
            {"type": "squat", "on": "rail_1", "position": 6.3, "a": 0.02, "h": 4e-4, "ridge": 0.5},
            "squat on rail_1: position 6.3 m, longitudinal semi-axis 20 mm, depth 0.4 mm, ridge 0.5",
        ),
        (
            {"type": "polygon", "on": "wheel_2", "harmonics": [{"order": 18, "amplitude": 1e-5}]},
            "polygon on wheel_2: harmonics [(order 18, amplitude 0.01 mm)]",
        ),
        ({"type": "burn", "on": "rail_9", "package": "p", "depth": 1e-3}, "burn on rail_9: depth 0.001"),
        ({"h": 10**400}, "irregularity of unknown type on an unknown surface: h beyond 1e+300"),
    ],
)
def test_words_have_the_units_of_people(item, words):
    assert description_of(item) == words


def test_each_shipped_irregularity_is_one_line_with_all_its_values():
    for name in shipped.names("scenarios"):
        for item in load_scenario(name).to_mapping()["irregularities"]:
            words = description_of(item)
            assert words.startswith(f"{item['type']} on {item['on']}: ")
            assert "\n" not in words
            given_values = [key for key, value in item.items() if value not in (None, "", [])]
            assert words.count(", ") + 1 >= len(given_values) - 2


anything = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=80),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(["type", "on", "a", "h", "harmonics", "table", "x"]), anything))
def test_whatever_a_bag_holds_has_words(item):
    assert isinstance(description_of(item), str)
    assert isinstance(description_of({**item, "type": "polygon"}), str)
