"""One kind fitted to forces of the toy: sizes, place, gain and speed come back, and derivatives are those."""

import dataclasses

import numpy as np
import pytest

from support.passing import ToyTracks, passed
from wheelset_track_sim.identification.fit import Problem
from wheelset_track_sim.identification.forward import Forward
from wheelset_track_sim.identification.kinds import KINDS
from wheelset_track_sim.identification.sampling import sample
from wheelset_track_sim.irregularities import Flat

FLAT = Flat("wheel_1", length=0.040)


def problem(kind, *observations):
    tracks = ToyTracks()
    return Problem(KINDS.get(kind), [Forward(each, tracks) for each in observations], 0)


@pytest.mark.slow
def test_a_flat_is_found_with_its_place_its_gain_and_its_speed():
    observation = passed(FLAT, place=0.25, gain=1.02, reported=1.004)
    flat = problem("flat", observation)
    found = flat.search(flat.starts(1)[0])
    values = dict(zip(flat.names, found.x, strict=True))
    assert np.exp(values["length_m"]) == pytest.approx(0.040, rel=0.02)
    assert values["place 0"] % 0.6 == pytest.approx(0.25, abs=0.02)
    assert 0.03 * values["gain 0"] == pytest.approx(0.02, abs=0.01)
    assert 0.6 < found.chi2 / flat.samples < 1.2
    deviation = np.sqrt(found.covariance[0, 0])
    assert abs(values["length_m"] - np.log(0.040)) < 4 * deviation < 0.1

    posterior = sample(flat, [found], seed=1, draws=16)
    lengths = np.exp(posterior.draws[:, 0])
    assert posterior.effective > 4
    assert lengths.std() / 0.040 == pytest.approx(deviation, rel=0.6)
    again = sample(flat, [found], seed=1, draws=16)
    assert np.array_equal(again.draws, posterior.draws)

    nothing = problem(None, observation)
    without = nothing.search(nothing.starts(1)[0])
    assert without.log_evidence < found.log_evidence - 100


def test_derivatives_are_those_of_the_signal():
    worn = problem("worn_flat", passed(Flat("wheel_1", length=0.040, worn_length=0.06)))
    x = worn.starts(1)[0]
    x[worn.at(0, "speed")] = 0.5
    slopes = worn.slopes(0, x)
    for name, step in (("lag", 1e-3), ("gain", 0.1), ("speed", 0.01)):
        column = worn.at(0, name)
        more, less = x.copy(), x.copy()
        more[column] += step
        less[column] -= step
        change = [worn.gain(0, at) * worn.predicted(0, at) for at in (more, less)]
        expected = (change[0] - change[1]) / (2 * step)
        assert slopes[:, column] == pytest.approx(expected, abs=0.02 * np.abs(expected).max()), name


def test_residuals_are_white_under_the_covariance():
    """With 4,000 draws of noise and errors of the model by their definition, the whitened covariance is that of 1."""
    observation = dataclasses.replace(passed(FLAT), shape_error=0.05)
    observation = dataclasses.replace(observation, time=observation.time[::8], values=observation.values[::8])
    flat = problem("flat", observation)
    forward = flat.forwards[0]
    n = len(forward.values)
    away = 0.05 * np.abs(forward.values - np.median(forward.values))
    alike = np.exp(-np.abs(forward.time[:, None] - forward.time) / 1e-3)
    root = np.linalg.cholesky(alike + 1e-12 * np.eye(n))
    random = np.random.default_rng(1)
    drawn = away[:, None] * (root @ random.standard_normal((n, 4000))) + 1e3 * random.standard_normal((n, 4000))
    covariance = np.cov(flat.whitened(0, drawn))
    assert np.abs(covariance - np.eye(n)).max() < 0.12


def test_draws_are_folded_into_the_ranges_of_sizes():
    flat = problem("flat", passed(FLAT))
    x = flat.starts(1)[0]
    found = flat.optimum(x)
    wide = dataclasses.replace(found, covariance=found.covariance + np.diag(np.eye(len(x))[0]) * 4.0)
    posterior = sample(flat, [wide], seed=2, draws=2)
    low, high = flat.bounds[0]
    assert ((posterior.draws[:, 0] >= low) & (posterior.draws[:, 0] <= high)).all()
