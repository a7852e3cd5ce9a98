import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.studies.damage_table import (
    DamageTable,
    _Row,
    _row,
    _sized,
    build_damage_table,
    load_damage_table,
)

SIZES, SPEEDS, LOADS = np.array([0.0, 0.02, 0.04]), np.array([20.0, 30.0]), np.array([1e5, 2e5])


@pytest.fixture
def table():
    """Peaks are linear in all three; damage is a power of the load, and its logarithm linear in the others."""
    size, speed, load = np.meshgrid(SIZES, SPEEDS, LOADS, indexing="ij")
    linear = 0.5 * load + 1e3 * speed + 2e6 * size
    peaks = np.stack([0.9 * linear, linear, 1.1 * linear], axis=-1)
    damage = (1e-30 * load**5 * np.exp(50.0 * size + 0.01 * speed))[..., np.newaxis]
    return DamageTable("irregularities.0.length", SIZES, SPEEDS, LOADS, ("A1",), damage, peaks)


def test_between_the_entries_it_is_what_it_is_of(table):
    sizes, speeds, loads = np.array([0.0, 0.01, 0.033]), np.array([20.0, 27.0, 30.0]), np.array([1e5, 1.7e5, 2e5])
    damage = table.damage_of(sizes, speeds, loads)
    assert damage[:, 0] == pytest.approx(1e-30 * loads**5 * np.exp(50.0 * sizes + 0.01 * speeds))
    peaks = table.peak_of(sizes, speeds, loads)
    assert peaks[:, 1] == pytest.approx(0.5 * loads + 1e3 * speeds + 2e6 * sizes)


def test_a_size_follows_from_its_peak(table):
    found = table.size_of(float(table.peak_of(0.03, 25.0, 1.5e5)[1]), 25.0, 1.5e5)
    assert found.estimate == pytest.approx(0.03)
    assert (found.low, found.high) == pytest.approx((0.0227272727, 0.0388888889))
    noisy = table.size_of(float(table.peak_of(0.03, 25.0, 1.5e5)[1]), 25.0, 1.5e5, 0.01)
    assert noisy.low < found.low < noisy.estimate == found.estimate < found.high < noisy.high
    assert table.size_of(1e3, 25.0, 1.5e5).estimate == 0.0


def test_what_is_outside_is_refused(table):
    with pytest.raises(InputError, match=r"^speed from 31 to 31 is outside the damage table, which has 20 to"):
        table.damage_of(0.02, 31.0, 1e5)
    with pytest.raises(InputError, match=r"^irregularities.0.length from -0.01 to 0.02 is outside the damage table"):
        table.peak_of([-0.01, 0.02], 25.0, 1e5)


def test_it_is_read_again(table, tmp_path):
    table.save(tmp_path / "table.npz")
    again = load_damage_table(tmp_path / "table.npz")
    for name, value in vars(table).items():
        assert np.array_equal(getattr(again, name), value)
    np.savez(tmp_path / "other.npz", key="speed", nodes=["A1"])
    with pytest.raises(InputError, match=r"other.npz is no damage table \(.*\): give a file of DamageTable.save"):
        load_damage_table(tmp_path / "other.npz")


def test_axes_have_to_rise():
    scenario, curve = load_scenario("flat_fresh"), load_curve("assumed_body")
    with pytest.raises(InputError, match=r"^sizes has 2 values that do not all rise"):
        build_damage_table(scenario, "irregularities.0.length", [0.03, 0.02], SPEEDS, LOADS, curve)


@pytest.mark.slow
def test_without_damage_it_is_the_closed_form_and_a_flat_adds_to_it():
    """Under the static load each turn is one cycle of the static bending."""
    scenario, curve = load_scenario("flat_fresh", ["output.stress_nodes=[A1]"]), load_curve("assumed_body")
    base, key, load = scenario.to_mapping(), "irregularities.0.length", 196.2e3
    (sound, even), (damaged, peaks) = (
        _row(_Row(_sized(base, key, size), (22.0,), (load,), curve, 10.0)) for size in (0.0, 0.04)
    )
    closed = (65.3e6 / curve.limit) ** curve.slope / curve.knee_cycles / 2.713
    assert sound.shape == (1, 1, 1)
    assert sound[0, 0, 0] == pytest.approx(closed, rel=0.08)
    assert damaged[0, 0, 0] > 1.2 * sound[0, 0, 0]
    assert even[0, 0] == pytest.approx(load / 2, rel=0.05)
    assert peaks[0, 0, 1] > 1.5 * even[0, 0, 1]
