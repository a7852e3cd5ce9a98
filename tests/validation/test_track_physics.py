"""The track against closed forms, and its two independent methods against each other and the known figures."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from wheelset_track_sim.track import bloch
from wheelset_track_sim.track import finite_elements as track_fe
from wheelset_track_sim.track.bay import half_sleeper
from wheelset_track_sim.track.track import HALVES, Track, load_track

pytestmark = pytest.mark.slow

TRACK = load_track("ballasted_60e1")


def finer(elements: int) -> Track:
    return replace(TRACK, rail=replace(TRACK.rail, elements_per_bay=elements))


def test_statics_of_both_methods_are_the_same_and_as_known() -> None:
    x = np.array([0.0, 0.037, 0.3, 0.55, 0.61, -1.4])
    for load, known in [(0.0, 1.112e-8), (0.3, 1.144e-8), (0.211, None)]:
        elements, waves = track_fe.receptance(TRACK, 0.0, load, x), bloch.receptance(TRACK, 0.0, load, x)
        for one, other in zip(elements, waves, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-20)
        if known:
            at_load = bloch.receptance(TRACK, 0.0, load, load)[0][0, 0]
            assert at_load.real == pytest.approx(known, rel=5e-4)


def test_resonances_are_where_they_are_known_to_be() -> None:
    frequencies = np.arange(20.0, 1200.0, 0.5)
    above, between = (np.abs(bloch.receptance(TRACK, frequencies, x, x)[0][0]) for x in (0.0, 0.3))
    assert frequencies[scipy.signal.argrelmax(above)][:2] == pytest.approx([75, 292], abs=1.5)
    assert frequencies[scipy.signal.argrelmin(above)][0] == pytest.approx(173, abs=1)
    assert frequencies[scipy.signal.argrelmax(between)][[0, 2]] == pytest.approx([75, 1073], abs=1)
    assert frequencies[scipy.signal.argrelmin(between)][0] == pytest.approx(163, abs=1)


# Away from the lightly damped pinned-pinned resonance, to which the ends of a finite track matter.
APART = np.array([20.0, 75.0, 163.0, 292.0, 500.0, 800.0, 1500.0, 2000.0, 2500.0])


def difference(track: Track, load: float, places: list[float], waves: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Largest difference of finite elements to ``waves`` a frequency, as part of the largest receptance there."""
    elements = track_fe.receptance(track, APART, load, places)
    level = np.abs(waves[0]).max(axis=0)
    return np.max([np.abs(a - b).max(axis=0) / level for a, b in zip(elements, waves, strict=True)], axis=0)


@pytest.mark.parametrize(("load", "places"), [(0.0, [0.0, 0.225, -1.35]), (0.3, [0.3, 0.6, 3.0])])
def test_finite_elements_converge_to_the_exact_waves(load: float, places: list[float]) -> None:
    waves = bloch.receptance(TRACK, APART, load, places)
    errors = [difference(finer(elements), load, places, waves) for elements in (8, 16, 32)]
    assert errors[0].max() / errors[1].max() == pytest.approx(4, rel=0.05)
    assert errors[1].max() / errors[2].max() == pytest.approx(4, rel=0.05)
    assert errors[2].max() < 0.011  # three metres away at 2500 Hz: the error of the wavelength adds up
    assert errors[0][APART < 300].max() < 1e-3


@pytest.mark.parametrize(("load", "places"), [(0.21, [0.21, 0.215, 0.0]), (0.1375, [0.1375, 0.1, 0.44])])
def test_loads_and_responses_inside_elements(load: float, places: list[float]) -> None:
    waves = bloch.receptance(TRACK, APART, load, places)
    assert difference(finer(64), load, places, waves).max() < 2e-3
    assert difference(TRACK, load, places, waves)[APART < 300].max() < 1e-3


def test_rail_on_soft_close_supports_is_a_beam_on_an_elastic_foundation() -> None:
    """Closed form of the Timoshenko beam on a Winkler foundation, static and dynamic: residues of its two waves."""
    track = replace(TRACK, spacing=0.2, pad=replace(TRACK.pad, stiffness=1e6, damping=2e3, length=0.0))
    rail = track.rail
    for frequency in (0.0, 20.0, 100.0, 400.0):
        omega = 2 * np.pi * frequency
        for half in HALVES:
            pad = track.pad.stiffness + 1j * omega * track.pad.damping
            compliance = 1 / pad + half_sleeper(track, half).receptance(np.array([omega]))[0]
            foundation = 1 / compliance / track.spacing

            stiff, turn = foundation - rail.rhoA * omega**2, rail.kGA - rail.rhoI * omega**2
            square, linear = rail.kGA * rail.EI, rail.kGA * turn + rail.EI * stiff - rail.kGA**2
            z = np.roots([square, linear, stiff * turn]).astype(complex)  # k^2 of the two waves
            k = np.sqrt(z)
            k = np.where(k.imag < 0, -k, k)
            expected = np.sum((rail.EI * z + turn) / (square * (z - z[::-1])) * 0.5j / k)
            over_sleeper = bloch.bloch_track(track, half, frequency).receptance(0.0, 0.0)[0, 0]
            assert abs(over_sleeper - expected) < 2e-3 * abs(expected)


def test_stiff_sleeper_heaves_and_rolls_on_its_ballast() -> None:
    stiff = replace(TRACK.sleeper, youngs_modulus=1e12, moment_of_inertia=1e-1, area=1.0, density=100.0)
    track = replace(TRACK, sleeper=stiff)
    heave = half_sleeper(track, "symmetric").receptance(np.array([0.0]))[0].real
    assert heave == pytest.approx(2 / track.ballast.stiffness, rel=1e-3)
    roll = half_sleeper(track, "antisymmetric").receptance(np.array([0.0]))[0].real
    turning = track.ballast.stiffness * track.sleeper.length**2 / 12 / 2  # of half a sleeper about the centre
    assert roll == pytest.approx((track.rail_distance / 2) ** 2 / turning, rel=0.01)


def test_mobility_at_high_frequency_is_the_step_of_the_rails_green_function() -> None:
    """G(0+) = 1 / (2 sqrt(rhoA kGA)): the rail's front is a shear wave, whatever the track below it is."""
    frequencies = np.arange(6000.0, 9000.0, 25.0)
    mobility = [
        (2j * np.pi * frequencies * bloch.receptance(TRACK, frequencies, x, x)[0][0]).real.mean()
        for x in np.arange(0.01, 0.6, 0.02)
    ]
    step = 1 / (2 * np.sqrt(TRACK.rail.rhoA * TRACK.rail.kGA))
    assert step == pytest.approx(4.1e-6, rel=0.01)
    assert np.mean(mobility) == pytest.approx(step, rel=0.05)
