import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.dynamics.green_functions import folded, frequency_grid, green_function, integrated


def oscillator(f: np.ndarray, f0: float, zeta: float) -> np.ndarray:
    """Receptance of a unit mass on spring and damper."""
    w0, w = 2 * np.pi * f0, 2 * np.pi * f
    return 1 / (w0**2 - w**2 + 2j * zeta * w0 * w)


def test_green_function_of_an_oscillator() -> None:
    f0, zeta, dt = 40.0, 0.1, 1e-4
    f, samples = frequency_grid(5000.0, 2.0, dt)
    green = green_function(oscillator(f, f0, zeta), samples, dt)
    t = np.arange(samples // 2) * dt
    w0 = 2 * np.pi * f0
    wd = w0 * np.sqrt(1 - zeta**2)
    exact = np.exp(-zeta * w0 * t) * np.sin(wd * t) / wd
    assert np.abs(green[: len(t)] - exact).max() < 3e-3 / wd  # the corner at t = 0 is beyond the band


@given(st.floats(5.0, 200.0), st.floats(0.02, 0.5), st.floats(500.0, 5000.0))
def test_the_sum_over_a_period_is_the_static_receptance(f0: float, zeta: float, band: float) -> None:
    dt = 1e-4
    f, samples = frequency_grid(band, 1.0, dt)
    receptance = oscillator(f, f0, zeta)
    assert dt * green_function(receptance, samples, dt).sum() == pytest.approx(receptance[0].real, rel=1e-9)


def test_a_band_limit_rings_before_time_zero_and_folding_takes_that_back() -> None:
    # a step at t = 0+ decaying with 1/tau: the inverse transform halves it at 0 and rings on both sides
    tau, dt = 0.01, 1e-5
    f, samples = frequency_grid(2500.0, 1.0, dt)
    green = green_function(1 / (1 / tau + 2j * np.pi * f), samples, dt)
    causal = folded(green)
    t = np.arange(2000) * dt
    exact = np.exp(-t / tau)
    assert green[0] == pytest.approx(0.5, abs=0.02)
    assert np.abs(green[-20:]).max() > 0.05
    assert causal[0] == pytest.approx(1.0, abs=0.03)
    one_sided, both = (dt * np.cumsum(found[: len(t)] - exact) for found in (green, causal))
    assert abs(both[-1]) < 0.2 * abs(one_sided[-1])  # what was lost before t = 0 is a compliance at lag zero


def test_eq_3_weighs_the_ends_by_half() -> None:
    assert integrated(np.ones(4), 0.1) == pytest.approx([0.05, 0.1, 0.1, 0.05])
