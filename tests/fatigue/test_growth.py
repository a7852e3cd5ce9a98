"""Laws of crack growth: files, limits, scatter."""

import dataclasses
import math

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.growth import load_crack_growth
from wheelset_track_sim.inputs import shipped

STEEL = load_crack_growth("assumed_steel")
MPA = 1e6  # Pa sqrt(m)


def nasgro(**changes):
    plain = dataclasses.replace(STEEL, law="nasgro", threshold=0.0, aspect_scatter=0.0)
    return dataclasses.replace(plain, **changes)


@pytest.mark.parametrize("name", shipped.names("cracks"))
def test_a_shipped_law_says_that_it_is_assumed(name):
    growth = load_crack_growth(name)
    assert growth.name == name
    assert growth.assumed


def test_the_fast_end_is_the_law_of_its_source():
    """5.21e-13 mm for N/mm^1.5 is 1.65e-11 m for MPa sqrt(m), and 63 N/mm^1.5 is 2 MPa sqrt(m)."""
    fast = STEEL.at("fast")
    in_metres = 5.21e-13 * 1e-3 * 1000**1.5
    assert fast.rate == pytest.approx(in_metres, rel=2e-3)
    assert fast.threshold == pytest.approx(63 / math.sqrt(1000) * MPA, rel=5e-3)
    assert (fast.aspect, fast.residual_stress) == (pytest.approx(0.6), 20e6)
    slow = STEEL.at("slow")
    assert (slow.rate, slow.threshold, slow.aspect) == (STEEL.rate / 2, 8 * MPA, pytest.approx(1.0))
    assert STEEL.at("middle").rate == STEEL.rate


def test_paris_opens_only_in_tension_and_has_a_threshold():
    law = dataclasses.replace(STEEL, threshold_slope=3 * MPA, least_threshold=2 * MPA)
    largest, ratio = np.array([4.5, 4.5, 4.5, 9.0, 9.0, -1.0]) * MPA, np.array([-1.0, 0.0, 0.3, 0.5, 0.9, 2.0])
    opened = np.array([4.5, 4.5, 3.15, 4.5, 0.9, 0.0])
    grows = [True, True, True, True, False, False]  # above 4, 4, 3.1, 2.5, 2 MPa sqrt(m)
    assert law.rate_of(largest, ratio, 1e-3) == pytest.approx(np.where(grows, law.rate * opened**3, 0.0))


def test_newmans_function_has_its_limits():
    law = nasgro()
    alpha = law.constraint
    assert law.opening(0.0) == pytest.approx((0.825 - 0.34 * alpha + 0.05 * alpha**2) * math.cos(0.15 * math.pi) ** 0.4)
    assert law.opening(-1e-12) == pytest.approx(float(law.opening(0.0)))
    assert law.opening(1.0 - 1e-9) == pytest.approx(1.0)
    ratios = np.linspace(-1.0, 0.99, 50)
    assert np.all(law.opening(ratios) >= ratios)
    assert np.all(np.diff(law.opening(ratios)) > 0)


def test_nasgro_without_its_ends_is_paris_by_the_open_range():
    law = nasgro()
    ratios = np.array([-1.0, 0.0, 0.5])
    expected = law.rate * ((1 - law.opening(ratios)) * 10) ** 3
    assert law.rate_of(10 * MPA, ratios, 1e-3) == pytest.approx(expected)
    high = law.rate_of(10 * MPA, 1 - 1e-6, 1e-3)
    assert high == pytest.approx(law.rate * 1e-5**3, rel=1e-2)  # open all the time: the full range


def test_nasgro_stops_at_its_threshold_and_grows_without_bound_at_fracture():
    law = nasgro(threshold=6 * MPA, p=0.5, q=0.5)
    at_threshold = 6 * math.sqrt(1e-3 / (1e-3 + law.intrinsic_length))
    closure = float((1 - law.opening(0.0)) / (1 - law.opening(0.0)))
    assert law.rate_of(0.999 * at_threshold * closure * MPA, 0.0, 1e-3) == 0.0
    assert law.rate_of(1.001 * at_threshold * closure * MPA, 0.0, 1e-3) > 0.0
    assert law.rate_of(59.9 * MPA, 0.0, 1e-3) > 10 * law.rate_of(50 * MPA, 0.0, 1e-3)
    assert law.rate_of(4 * MPA, 0.0, 1e-5) > 0.0  # a short crack has a lower threshold


def written(path, **changes):
    keys = dataclasses.asdict(STEEL) | changes
    path.write_text("".join(f"{key}: {value!r}\n" for key, value in keys.items() if value is not None))
    return path


def test_values_have_units(tmp_path):
    found = load_crack_growth(written(tmp_path / "a.yaml", threshold="5 MPa sqrtm", rate="1e-9 mm", source="test"))
    assert (found.threshold, found.rate, found.assumed) == (5 * MPA, 1e-12, False)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"source": None}, "source is missing"),
        ({"source": " "}, "source is empty: say where the constants come from"),
        ({"law": "walker"}, "is not a known choice"),
        ({"toughness": None}, "toughness is missing"),
        ({"threshold_factor": None}, "threshold_factor is missing"),
        ({"threshold": "5 MPa"}, "is not in a unit of this quantity: .* Pa sqrtm, MPa sqrtm"),
        ({"aspect": 0.9}, "aspect = 0.9 with aspect_scatter = 0.2 leaves 0 to 1"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        load_crack_growth(written(tmp_path / "a.yaml", **changes))
