"""The blind zone: where a bridge reads a hit, and where it does not."""

import csv

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.studies import blind_zone
from wheelset_track_sim.studies.blind_zone import Hits


def test_shares_are_of_the_dynamic_part_scaled_to_a_hit():
    found = Hits(np.arange(4.0), np.full(4, 200e3), np.array([100e3, 150e3, 190e3, 200e3]))
    np.testing.assert_allclose(found.of_hit(100e3), [100e3, 200e3, 280e3, 300e3])
    assert found.missed(100e3) == "50 % below 250 kN and 25 % below 200 kN"


def test_without_damage_at_an_angle_there_is_nothing_to_read():
    with pytest.raises(InputError, match="needs damage on wheel_1 at an angle: give a breakout or a flat"):
        blind_zone.hits(load_scenario("undamaged"))


@pytest.mark.slow
def test_a_hit_is_read_between_the_gauges_alone(tmp_path, monkeypatch):
    """Five angles; one of them is between the gauges."""
    found = blind_zone.hits(load_scenario("damage_wheel_1"), 5)
    monkeypatch.setattr(blind_zone, "hits", lambda scenario, progress: found)
    paths = blind_zone.draw(tmp_path, load_scenario("damage_wheel_1"))
    one, array = found
    within = (one.place > 0.16) & (one.place < 0.41)
    assert within.sum() == 1
    assert (one.read[within] > 0.75 * one.true[within]).all()
    assert (one.read[(one.place < 0.1) | (one.place > 0.42)] < 120e3).all()
    assert (array.true > 255e3).all()
    assert len(array.place) == 5
    assert {path.name for path in paths} >= {"blind_zone.png", "blind_zone_shear_single.csv"}
    with (tmp_path / "blind_zone_shear_array.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["peak read (N)"]) for row in rows] == pytest.approx(array.read, rel=1e-4)
