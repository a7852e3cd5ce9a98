"""Smallest, median and largest of places and of turns."""

import numpy as np

from wheelset_track_sim.samples import spread
from wheelset_track_sim.samples.spread import Spread, TurnSpread, spreads
from wheelset_track_sim.samples.turns import TurnPeaks


def test_numbers_of_nested_mappings_become_spreads():
    items = [{"a": {"x": value}, "b": -value} for value in (3.0, 1.0, 2.0)]
    assert spreads(items) == {
        "a": {"x": {"min": 1.0, "median": 2.0, "max": 3.0}},
        "b": {"min": -3.0, "median": -2.0, "max": -1.0},
    }


def test_turns_are_thinned_and_ends_stay_exact(monkeypatch):
    monkeypatch.setattr(spread, "MOST_TURNS", 8)
    turns = TurnSpread()
    assert turns.spreads == ()
    values = np.random.default_rng(1).permutation(1000.0 + np.arange(500))
    for number, value in enumerate(values):
        turns.push(TurnPeaks(number + 1, (value, 1.0), (2.0,)))
        assert len(turns._kept) < 16
    force, other, node = turns.spreads
    assert (turns.turns, force.low, force.high) == (500, 1000.0, 1499.0)
    assert 1100 < force.median < 1400
    assert (other, node) == (Spread(1.0, 1.0, 1.0), Spread(2.0, 2.0, 2.0))
