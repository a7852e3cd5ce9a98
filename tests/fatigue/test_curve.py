"""S-N curves: files, rules of Miner, mean stress."""

import math

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow_kernels import damage_of, equivalent_amplitude
from wheelset_track_sim.inputs import shipped


@pytest.mark.parametrize("name", shipped.names("woehler"))
def test_a_shipped_curve_says_that_it_is_assumed(name):
    curve = load_curve(name)
    assert curve.name == name
    assert curve.assumed


def written(path, **changes):
    keys = {"name": "mine", "source": "test", "fatigue_limit": "100 MPa", "knee_cycles": 2e6, "slope": 4.0}
    keys |= {"survival_probability": 0.975} | changes
    path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items() if value is not None))
    return path


def test_a_file_with_factors_and_a_second_slope(tmp_path):
    curve = load_curve(written(tmp_path / "a.yaml", second_slope=9.0, size_factor=0.9, surface_factor=0.8))
    assert curve.limit == pytest.approx(72e6)
    assert not curve.assumed
    assert curve.rules == ("elementary", "haibach", "original", "curve")
    assert curve.constants[:, 3].tolist() == [4.0, 7.0, math.inf, 9.0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"source": None}, "source is missing"),
        ({"source": "' '"}, "source is empty: say where the constants come from"),
        ({"slope": None}, "slope is missing"),
        ({"survival_probability": None}, "survival_probability is missing"),
        ({"fatigue_limit": "0 MPa"}, "fatigue_limit = 0 MPa, which is 0 Pa, is out of range: give the amplitude"),
        ({"mean_stress": "fkm"}, "mean_stress = fkm with mean_stress_sensitivity = 0: give"),
        ({"mean_stress": "goodman"}, "is not a known choice"),
        ({"knee": 1}, "knee is not a known key: known are name"),
    ],
)
def test_what_a_curve_cannot_be_is_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        load_curve(written(tmp_path / "a.yaml", **changes))


def test_rules_differ_below_the_knee_alone(tmp_path):
    curve = load_curve(written(tmp_path / "a.yaml"))
    above = [damage_of(150e6, rule) for rule in curve.constants]
    assert above == pytest.approx([1.5**4 / 2e6] * 3)
    below = [damage_of(50e6, rule) for rule in curve.constants]
    assert below == pytest.approx([0.5**4 / 2e6, 0.5**7 / 2e6, 0.0])
    assert {damage_of(100e6, rule) for rule in curve.constants} == {1 / 2e6}


def test_equal_damage_over_the_mean_is_continuous_with_the_slopes_of_its_regions():
    sensitivity, amplitude = 0.3, 100.0
    means = np.linspace(-300, 500, 8001)
    found = np.array([equivalent_amplitude(amplitude, mean, sensitivity) for mean in means])
    assert np.abs(np.diff(found)).max() < 0.31 * (means[1] - means[0])
    assert equivalent_amplitude(amplitude, 0.0, sensitivity) == amplitude
    assert equivalent_amplitude(amplitude, -200.0, sensitivity) == pytest.approx(70.0)
    assert equivalent_amplitude(amplitude, 100.0, sensitivity) == pytest.approx(130.0)  # R = 0
    assert equivalent_amplitude(amplitude, 300.0, sensitivity) == pytest.approx(130.0 * 1.3 / 1.1)  # R = 0.5
    assert equivalent_amplitude(amplitude, 77.0, 0.0) == amplitude
