import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Roughness, rail_heights, tread_heights
from wheelset_track_sim.irregularities.roughness import LIMIT_LEVELS, LIMIT_WAVELENGTHS

DX = 0.001


def test_third_octaves_have_their_levels():
    rough = Roughness("rail_1", 30.0, seed=3, level=6.0)
    line = rough.height(np.arange(30_000)[:, None] * DX, np.zeros((1, 1)))[:, 0]
    power = 2 * np.abs(np.fft.rfft(line) / len(line)) ** 2
    wavelength = 30.0 / np.maximum(np.arange(len(power)), 1e-9)
    for centre in (0.25, 0.1, 0.04, 0.0125):
        band = (wavelength > centre * 2 ** (-1 / 6)) & (wavelength <= centre * 2 ** (1 / 6))
        limit = np.interp(np.log(centre), np.log(LIMIT_WAVELENGTHS[::-1]), LIMIT_LEVELS[::-1])
        assert 10 * np.log10(power[band].sum() / 1e-12) == pytest.approx(limit + 6.0, abs=1.5)
    assert power[(wavelength > 0.55) | (wavelength < 0.0049)].sum() < 1e-20


def test_neighbouring_lines_lose_coherence_with_their_distance():
    rough = Roughness("rail_2", 30.0, longest=0.1)
    y = np.array([0.0, 0.002, 0.006, 0.030])
    waves = np.fft.rfft(rough.height(np.arange(30_000)[:, None] * DX, y[None, :]), axis=0)[600:750]  # 40 to 50 mm
    across = (waves * waves[:, :1].conj()).sum(axis=0).real / (np.abs(waves[:, 0]) ** 2).sum()
    np.testing.assert_allclose(across, np.exp(-2 * np.pi / 0.0445 * y), atol=0.15)


def test_repeats_without_a_seam_and_is_its_seed_alone():
    rough = Roughness("wheel_1", 2713 * DX, seed=5)
    y = np.linspace(-0.01, 0.01, 5)
    heights = tread_heights([rough], "wheel_1", 2713, DX, y)
    steps = np.abs(np.diff(np.concatenate([heights, heights[:1]]), axis=0))
    assert steps[-1].max() < 1.5 * np.quantile(steps, 0.999)
    assert heights.any(axis=1).all()
    assert not tread_heights([rough], "wheel_2", 2713, DX, y).any()
    same, other = Roughness("wheel_1", 2713 * DX, seed=5), Roughness("wheel_1", 2713 * DX, seed=6)
    assert (tread_heights([same], "wheel_1", 2713, DX, y) == heights).all()
    assert (tread_heights([other], "wheel_1", 2713, DX, y) - heights).std() > 0.5 * heights.std()


def test_heights_are_the_same_on_a_grid_and_point_by_point():
    rough = Roughness("rail_1", 1.0)
    s, y = np.array([0.1, 0.35, 0.7]), np.array([-0.002, 0.004])
    grid = rough.height(s[:, None], y[None, :])
    assert rough.height(s, 0.004) == pytest.approx(grid[:, 1], rel=1e-9)
    assert rough.height(0.35, -0.002) == pytest.approx(grid[1, 0], rel=1e-9)
    assert rail_heights([rough], "rail_1", 1000, DX, y)[350] == pytest.approx(
        rough.height(np.array([[0.35]]), y[None, :])[0], rel=1e-9
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"on": "wheel_3"}, "on = 'wheel_3'"),
        ({"length": np.nan}, "length = nan"),
        ({"level": 80.0}, "level = 80"),
        ({"shortest": 0.03, "longest": 0.0301, "length": 0.1}, "no wave between"),
    ],
)
def test_what_makes_no_sense_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        Roughness(**{"on": "rail_1", "length": 1.0} | change)
