from itertools import pairwise

import numpy as np
import pytest
import scipy

from wheelset_track_sim.dynamics.hold import ALIASED, RESOLVED, hold, hold_coefficients

DT = 36e-6


def by_quadrature(pole: complex, weight) -> complex:
    def integrand(tau: float) -> complex:
        return np.exp(pole * (DT - tau)) * weight(tau / DT)

    parts = [
        scipy.integrate.quad(lambda tau, f=f: f(integrand(tau)), 0.0, DT, epsabs=0.0, epsrel=1e-12)[0]
        for f in (np.real, np.imag)
    ]
    return complex(*parts)


@pytest.mark.parametrize("pole", [-1e-6 + 0j, -300 + 900j, -900 - 31000j, -14000 + 0j, -5e4 + 2e4j, -1000 + 13888j])
def test_weights_are_the_integrals_of_the_hold(pole: complex) -> None:
    b0, b1 = hold_coefficients(np.array([pole]), DT)
    assert b0[0] == pytest.approx(by_quadrature(pole, lambda s: 1 - s), rel=1e-9)
    assert b1[0] == pytest.approx(by_quadrature(pole, lambda s: s), rel=1e-9)


def test_series_and_closed_form_meet() -> None:
    """A jump where they meet would show against the slope on either side."""
    angles = np.linspace(0, 2 * np.pi, 17)
    below, above = (hold_coefficients(radius * np.exp(1j * angles) / DT, DT) for radius in (0.5 - 1e-9, 0.5 + 1e-9))
    for low, high in zip(below, above, strict=True):
        np.testing.assert_allclose(low, high, rtol=5e-9)


def test_a_pole_at_rest_gives_the_trapezoidal_rule() -> None:
    b0, b1 = hold_coefficients(np.array([0.0, -1e-300]), DT)
    np.testing.assert_array_equal(b0, DT / 2)
    np.testing.assert_array_equal(b1, DT / 2)


def test_a_ramp_is_followed_exactly_at_any_step_length() -> None:
    """q' = lambda q + g0 + c t has a closed solution; twenty steps must land on it."""
    pole, g0, c = -200 + 3000j, 2.0, -7e3
    for dt in (1e-8, 1e-5, 1e-3):
        a = np.exp(pole * dt)
        b0, b1 = (weight[0] for weight in hold_coefficients(np.array([pole]), dt))
        q, t = 0j, 0.0
        for step in range(20):
            t = (step + 1) * dt
            q = a * q + b0 * (g0 + c * (t - dt)) + b1 * (g0 + c * t)
        exact = (g0 / pole + c / pole**2) * (np.exp(pole * t) - 1) - c * t / pole
        assert q == pytest.approx(exact, rel=1e-6)


def test_modes_that_the_step_does_not_resolve_follow_their_load_at_once() -> None:
    half = np.pi / DT
    poles = np.array([-30 + 0.999j * RESOLVED * half, -30 + 1.001j * ALIASED * half, -30 - 3j * half])
    step = hold(poles, DT)
    np.testing.assert_array_equal(step.factor[1:], 0.0)
    np.testing.assert_array_equal(step.before[1:], 0.0)
    np.testing.assert_allclose(step.after[1:], -1 / poles[1:], rtol=1e-15)
    before, after = hold_coefficients(poles, DT)
    assert (step.factor[0], step.before[0], step.after[0]) == (np.exp(poles[0] * DT), before[0], after[0])


def test_a_mode_in_between_is_partly_stepped() -> None:
    """Under a load that rises from zero at a constant rate: so much of the one, so much of the other."""
    pole = np.array([-30 + (0.4 * RESOLVED + 0.6 * ALIASED) * 1j * np.pi / DT])
    before, after = (weight[0] for weight in hold_coefficients(pole, DT))
    share = 0.4**2 * (3 - 2 * 0.4)
    step, q, stepped, factor = hold(pole, DT), 0j, 0j, np.exp(pole[0] * DT)
    for n in range(50):
        q = step.factor[0] * q + step.before[0] * n + step.after[0] * (n + 1)
        stepped = factor * stepped + before * n + after * (n + 1)
        assert q == pytest.approx(share * stepped - (1 - share) * (n + 1) / pole[0], rel=1e-9)


@pytest.mark.parametrize("share", [RESOLVED, ALIASED])
def test_nothing_jumps_at_either_border(share: float) -> None:
    load = np.random.default_rng(1).normal(size=200)
    ends = []
    for side in (share - 1e-7, share + 1e-7):
        pole = np.array([-30 + 1j * side * np.pi / DT])
        step, q = hold(pole, DT), -load[0] / pole[0]
        for before, after in pairwise(load):
            q = step.factor[0] * q + step.before[0] * before + step.after[0] * after
        ends.append(q * pole[0])
    assert abs(ends[1] - ends[0]) < 1e-3 * np.abs(load).max()


def test_every_step_has_the_statics_of_its_mode() -> None:
    """Under a constant load q = (b0 + b1) g / (1 - a) = -g / lambda, resolved or not."""
    poles = -np.geomspace(1, 1e4, 20) + 1j * np.linspace(0, 2e5, 20)
    step = hold(poles, DT)
    np.testing.assert_allclose((step.before + step.after) / (1 - step.factor), -1 / poles, rtol=1e-8)
