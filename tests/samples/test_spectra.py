"""Spectra against closed forms: tones, noise, energy, bands."""

import numpy as np
import pytest

from wheelset_track_sim import InputError
from wheelset_track_sim.irregularities.roughness import Roughness
from wheelset_track_sim.samples.spectra import density, reference_of, roughness_levels, third_octaves

RATE = 20_000.0


@pytest.fixture(scope="module")
def noise():
    return 3.0 * np.random.default_rng(5).standard_normal(200_000) + 7.0


def tone(frequency, amplitude=2.0, count=100_000):
    return amplitude * np.sin(2 * np.pi * frequency * np.arange(count) / RATE)


def test_the_energy_of_a_spectrum_is_the_variance(noise):
    assert density(noise, RATE).mean_square == pytest.approx(noise.var(), rel=0.01)
    assert density(tone(431.0), RATE).mean_square == pytest.approx(2.0, rel=0.002)
    mixed = noise + tone(1000.0, 5.0, len(noise))
    assert density(mixed, RATE).mean_square == pytest.approx(mixed.var(), rel=0.01)


def test_white_noise_is_flat_and_a_tone_is_where_it_is(noise):
    found = density(noise, RATE, 20.0)
    assert found.step == 20.0
    assert found.density[2:-2].mean() == pytest.approx(9.0 / (RATE / 2), rel=0.02)
    sharp = density(tone(1234.0), RATE, 2.0)
    assert sharp.frequency[sharp.density.argmax()] == 1234.0


def test_a_tone_is_all_in_its_band_and_has_its_level():
    bands = third_octaves(density(tone(1000.0, np.sqrt(2.0)), RATE))
    assert bands.levels(1e-6).max() == pytest.approx(120.0, abs=0.02)  # an rms of 1 m/s^2 re 1e-6
    assert bands.middle[bands.mean_square.argmax()] == pytest.approx(1000.0)
    assert bands.mean_square.sum() == pytest.approx(1.0, rel=0.002)


def test_bands_hold_the_energy_between_their_outer_edges(noise):
    found = density(noise, RATE)
    bands = third_octaves(found)
    assert bands.middle[1:] / bands.middle[:-1] == pytest.approx(10**0.1)
    low, high = bands.middle[0] * 10**-0.05, bands.middle[-1] * 10**0.05
    assert high <= RATE / 2 < high * 10**0.1
    held = (found.frequency > low) & (found.frequency < high)
    assert bands.mean_square.sum() == pytest.approx(found.density[held].sum() * found.step, rel=1e-3)
    assert np.diff(bands.levels(1.0)).mean() == pytest.approx(1.0, abs=0.1)  # 1 dB a band: each is wider by 10^0.1


def test_references_are_those_of_the_units():
    assert [reference_of(unit) for unit in ("m/s^2", "N", "Pa")] == [1e-6, 1e-6, 1.0]


def test_a_wave_of_a_surface_has_its_level_at_its_wavelength():
    dx, wavelength, amplitude = 1e-3, 0.0398, 10e-6
    heights = amplitude * np.sin(2 * np.pi * np.arange(60_000) * dx / wavelength)
    lengths, levels = roughness_levels(heights, dx)
    at = levels.argmax()
    assert lengths[at] == pytest.approx(0.0398, rel=0.01)
    assert levels[at] == pytest.approx(20 * np.log10(10 / np.sqrt(2)), abs=0.02)
    assert (np.diff(lengths) < 0).all()


def test_roughness_has_the_levels_that_it_was_made_with():
    rough = Roughness(on="rail_1", level=6.0, seed=3)
    heights = rough.field(60_000, 1e-3, np.zeros(1))[:, 0]
    lengths, levels = roughness_levels(heights, 1e-3)
    inside = (lengths > 0.0126) & (lengths < 0.3)
    assert levels[inside] == pytest.approx(rough.levels(lengths[inside]), abs=2.5)
    assert (levels - rough.levels(lengths))[inside].mean() == pytest.approx(0.0, abs=0.5)


@pytest.mark.parametrize(("count", "resolution"), [(40, None), (3000, 1.0)])
def test_signals_that_are_too_short_are_refused(count, resolution):
    with pytest.raises(InputError, match=rf"the signal has {count} samples \({count / RATE:.4g} s\): give"):
        density(np.zeros(count), RATE, resolution)
