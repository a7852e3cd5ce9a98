import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Roughness, rail_heights, tread_heights
from wheelset_track_sim.irregularities.roughness import LIMIT_LEVELS, LIMIT_WAVELENGTHS

DX = 0.001
TABLE = ((0.5, 20.0), (0.1, 5.0), (0.02, -12.0))


@pytest.mark.parametrize("table", [(), TABLE], ids=["ISO 3095", "table"])
def test_third_octaves_have_their_levels(table):
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
        ({"on": "wheel_1", "length": 3.0}, "start and length are of rails"),
        ({"on": "wheel_1", "start": 3.0}, "start and length are of rails"),
        ({"start": 3.0}, r"start = 3 m is that of a stretch without a length: give its length"),
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
