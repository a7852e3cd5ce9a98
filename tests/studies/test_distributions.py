import numpy as np
import pytest
from scipy import stats

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.studies.distributions import Distribution, read_distribution
from wheelset_track_sim.studies.sampling import Sampling

SHARES = np.linspace(0.01, 0.99, 25)


@pytest.mark.parametrize(
    ("distribution", "of_scipy"),
    [
        (Distribution("uniform", low=2.0, high=5.0), stats.uniform(2.0, 3.0)),
        (Distribution("normal", mean=3.0, deviation=0.5), stats.norm(3.0, 0.5)),
        (
            Distribution("normal", mean=3.0, deviation=0.5, low=2.8, high=4.0),
            stats.truncnorm(-0.4, 2.0, loc=3.0, scale=0.5),
        ),
        (
            Distribution("lognormal", mean=3.0, deviation=0.5),
            stats.lognorm(np.sqrt(np.log1p(1 / 36)), scale=3.0 / np.sqrt(1 + 1 / 36)),
        ),
    ],
    ids=lambda each: getattr(each, "kind", ""),
)
def test_values_are_those_of_scipy(distribution, of_scipy):
    assert distribution.values(SHARES) == pytest.approx(of_scipy.ppf(SHARES), rel=1e-9)
    assert np.isfinite(distribution.values([0.0, 1.0])).all()


def test_mean_and_deviation_of_a_lognormal_distribution_are_its_own():
    drawn = Distribution("lognormal", mean=3.0, deviation=0.5).values(np.random.default_rng(1).random(200_000))
    assert (drawn.mean(), drawn.std()) == pytest.approx((3.0, 0.5), rel=0.01)


def test_values_stay_within_limits():
    bounded = Distribution("lognormal", mean=1.0, deviation=2.0, low=0.5, high=1.5)
    assert bounded.values([0.0, 1.0]) == pytest.approx([0.5, 1.5])


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ({"distribution": "gauss"}, "vary.speed.distribution = 'gauss' is not a known distribution"),
        ({"distribution": "normal", "mean": 3}, "vary.speed.deviation is missing: a normal distribution needs mean"),
        ({"distribution": "normal", "mean": 3, "deviation": 1, "sd": 2}, "vary.speed.sd is not a known key"),
        ({"distribution": "normal", "mean": "3 kN", "deviation": 1}, "vary.speed.mean = '3 kN' is not in a unit"),
        ({"distribution": "normal", "mean": 3, "deviation": 0}, "vary.speed: deviation = 0 is out of range"),
        ({"distribution": "uniform", "low": 3, "high": 2}, "vary.speed: low = 3 is not below high = 2"),
        ({"distribution": "lognormal", "mean": -3, "deviation": 2}, "vary.speed: mean = -3 cannot be that of"),
        ({"distribution": "normal", "mean": 3, "deviation": 1, "low": 90}, "vary.speed: low = 90 and high = inf leave"),
        ({"distribution": "uniform", "low": True, "high": 2}, "vary.speed.low = True is not a finite number"),
    ],
)
def test_refusals(data, reason):
    with pytest.raises(InputError, match=f"^{reason.replace('(', '.')}"):
        read_distribution(data, "m/s", "vary.speed")


def test_units():
    assert read_distribution({"distribution": "uniform", "low": "36 km/h", "high": 20}, "m/s", "speed") == Distribution(
        "uniform", low=10.0, high=20.0
    )


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube", "random"])
def test_draws_fill_the_cube_and_repeat(method):
    sampling = Sampling(64, method, seed=3)
    drawn = sampling.draws(2)
    assert drawn.shape == (64, 2)
    assert np.array_equal(drawn, sampling.draws(2))
    assert not np.array_equal(drawn, Sampling(64, method, seed=4).draws(2))
    counts = np.bincount((8 * drawn[:, 0]).astype(int), minlength=8)
    assert (counts == 8).all() or method == "random"


def test_a_sobol_design_needs_a_power_of_two():
    with pytest.raises(InputError, match=r"^count = 100 is no power of two, and a sobol design needs one: give 64 or"):
        Sampling(100)
