from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from support.written import forms
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.irregularities import Roughness, rail_heights, tread_heights
from wheelset_track_sim.irregularities.roughness import LIMIT_LEVELS, LIMIT_WAVELENGTHS

DX = 0.001
TABLE = ((0.5, 20.0), (0.1, 5.0), (0.02, -12.0))


@pytest.mark.parametrize("table", [(), TABLE], ids=["ISO 3095", "table"])
def test_third_octaves_have_their_levels(table):
    with pytest.warns(InputWarning, match="used from 0.005 to 0.02 m") if table else nullcontext():
        rough = Roughness("rail_1", seed=3, level=6.0, spectrum=table)
    known = np.array(sorted(table or zip(LIMIT_WAVELENGTHS, LIMIT_LEVELS, strict=True)))
    line = rough.field(30_000, DX, np.zeros(1))[:, 0]
    power = 2 * np.abs(np.fft.rfft(line) / len(line)) ** 2
    wavelength = 30.0 / np.maximum(np.arange(len(power)), 1e-9)
    for centre in (0.25, 0.1, 0.04, 0.0125):
        band = (wavelength > centre * 2 ** (-1 / 6)) & (wavelength <= centre * 2 ** (1 / 6))
        limit = np.interp(np.log(centre), np.log(known[:, 0]), known[:, 1])
        assert 10 * np.log10(power[band].sum() / 1e-12) == pytest.approx(limit + 6.0, abs=1.5)
    assert power[(wavelength > 0.55) | (wavelength < 0.0049)].sum() < 1e-20


def test_neighbouring_lines_lose_coherence_with_their_distance():
    y = np.array([0.0, 0.002, 0.006, 0.030])
    waves = np.fft.rfft(Roughness("rail_2", longest=0.1).field(30_000, DX, y), axis=0)[600:750]  # 40 to 50 mm
    across = (waves * waves[:, :1].conj()).sum(axis=0).real / (np.abs(waves[:, 0]) ** 2).sum()
    np.testing.assert_allclose(across, np.exp(-2 * np.pi / 0.0445 * y), atol=0.15)


def test_repeats_without_a_seam_and_is_its_seed_alone():
    y = np.linspace(-0.01, 0.01, 5)
    heights = tread_heights([Roughness("wheel_1", seed=5)], "wheel_1", 2713, DX, y)
    steps = np.abs(np.diff(np.concatenate([heights, heights[:1]]), axis=0))
    assert steps[-1].max() < 1.5 * np.quantile(steps, 0.999)
    assert heights.any(axis=1).all()
    assert not tread_heights([Roughness("wheel_1", seed=5)], "wheel_2", 2713, DX, y).any()
    assert (tread_heights([Roughness("wheel_1", seed=5)], "wheel_1", 2713, DX, y) == heights).all()
    other = tread_heights([Roughness("wheel_1", seed=6)], "wheel_1", 2713, DX, y)
    assert (other - heights).std() > 0.5 * heights.std()


def test_a_stretch_of_rail_rises_and_falls_and_leaves_the_rest_smooth():
    y = np.zeros(1)
    part = Roughness("rail_1", seed=1, start=2.0, length=3.0, ramp=0.5)
    heights = rail_heights([part], "rail_1", 10_000, DX, y).all()[:, 0]
    assert not heights[:2000].any()
    assert not heights[5001:].any()
    middle = heights[2500:4501]
    assert middle == pytest.approx(part.field(3001, DX, y)[500:2501, 0], abs=1e-20)
    assert np.abs(heights[2000:2100]).max() < 0.1 * np.abs(middle).max()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"on": "wheel_3"}, "on = 'wheel_3'"),
        ({"length": np.nan}, "length = nan"),
        ({"level": 80.0}, "level = 80"),
        ({"shortest": 0.03, "longest": 0.02}, "longest = 0.02 m is less than shortest = 0.03 m"),
        ({"on": "wheel_1", "length": 3.0}, "start and length apply to rails only"),
        ({"on": "wheel_1", "start": 3.0}, "start and length apply to rails only"),
        ({"start": 3.0}, r"start = 3 m needs a length: give the length"),
        ({"length": 3.0, "ramp": 2.0}, "ramp = 2 m at both ends is more than length = 3 m"),
        ({"spectrum": ((0.1, 3.0),)}, "spectrum has one entry"),
        ({"spectrum": ((0.1, 3.0), (-1.0, 2.0))}, r"spectrum\.1\.0 = -1 m is out of range"),
        ({"spectrum": ((0.1, 3.0), (0.1, 2.0))}, "names a wavelength twice"),
    ],
)
def test_what_makes_no_sense_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        Roughness(**{"on": "rail_1"} | change)


def test_waves_that_steps_cannot_hold_are_refused():
    with pytest.raises(InputError, match="less than two steps"):
        Roughness("rail_1").field(1000, 0.004, np.zeros(1))
    with pytest.raises(InputError, match="no wave between"):
        Roughness("rail_1", shortest=0.03, longest=0.0301).field(100, DX, np.zeros(1))


LEVELS = ((0.4, 17.1), (0.1, 5.0), (0.0315, -5.0), (0.00315, -11.0))


@given(form=forms(), unit=st.sampled_from(["m", "cm", "mm"]))
def test_a_file_of_any_form_and_unit_is_the_spectrum(tmp_path_factory, form, unit):
    size = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}[unit]
    rows = [(float(f"{wavelength / size:.12g}"), level) for wavelength, level in LEVELS]
    path = form.write(tmp_path_factory.getbasetemp() / "spectrum.txt", ("wavelength", "level"), (unit, "dB"), rows)
    assert Roughness("rail_1", file=str(path)).spectrum == LEVELS


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wavelength,level\n0.1,3\n0.01,4\n", "'wavelength' has no unit"),
        ("wavelength [m],level [um]\n0.1,3\n0.01,4\n", r"unit of 'level \[um\]' is not a unit of level: give dB"),
        ("wavelength [m],a,b\n0.1,3,1\n0.01,4,1\n", r"has wavelength \[m\], a, b: name the columns wavelength"),
        ("wavelength [deg],level\n0.1,3\n0.01,4\n", "is not a unit of length"),
        ("wavelength [km],level\n0.1,3\n0.01,4\n", r"spectrum\.0\.0 = 100 m is out of range"),
    ],
)
def test_files_that_are_no_spectrum_are_refused(tmp_path, text, words):
    (tmp_path / "spectrum.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        Roughness("rail_1", file=str(tmp_path / "spectrum.csv"))


@given(low=st.floats(0.0005, 20.0), high=st.floats(0.0005, 20.0))
def test_a_band_that_a_spectrum_does_not_cover_is_refused_or_warned_of(low, high):
    """F9: wavelengths in cm were taken for m, and the band got the last level all along."""
    low, high = sorted((low, high))
    assume(high > 1.01 * low)
    first, last = max(0.005, low / 1.26), min(0.5, high * 1.26)
    covered = max(0.0, np.log(last / first) / np.log(100.0))
    assume(abs(covered - 0.5) > 1e-6)
    assume(abs(low - 0.0063) > 1e-6)
    assume(abs(high - 0.5 / 1.26) > 1e-6)
    if covered < 0.5:
        told = pytest.raises(InputError, match=r"spectrum covers wavelengths from .* and roughness is made from")
    elif low > 0.0063 or high < 0.5 / 1.26:
        told = pytest.warns(InputWarning, match="its end levels are used from")
    else:
        told = nullcontext()
    with told:
        Roughness("rail_1", spectrum=((high, -10.0), (low, -30.0)))


def test_wavelengths_in_cm_are_recognised():
    with pytest.raises(
        InputError, match=r"covers wavelengths from 0.315 to 10 m, .* give wavelengths in m, if these are in cm"
    ):
        Roughness("rail_1", spectrum=((10, 14.0), (3.15, 5.0), (0.315, -1.0)))


@pytest.mark.parametrize(
    ("spectrum", "missing"),
    [
        (((0.5, 3.0), (0.02, 2.0)), "0.005 to 0.02 m,"),
        (((0.1, 3.0), (0.005, 2.0)), "0.1 to 0.5 m,"),
        (((0.2, 3.0), (0.01, 2.0)), "0.005 to 0.01 m and 0.2 to 0.5 m,"),
    ],
)
def test_what_is_missing_is_warned_of(spectrum, missing):
    with pytest.warns(InputWarning, match=f"its end levels are used from {missing}"):
        Roughness("rail_1", spectrum=spectrum)


def test_levels_of_no_surface_are_warned_of():
    with pytest.warns(
        InputWarning, match=r"spectrum has 40 dB re 1 um at a wavelength of 0\.005 m, which is 0\.02 of the wavelength"
    ):
        Roughness("rail_1", spectrum=((0.5, 40.0), (0.005, 40.0)))
