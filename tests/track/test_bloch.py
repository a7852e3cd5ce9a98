import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.track import bloch
from wheelset_track_sim.track import finite_elements as track_fe
from wheelset_track_sim.track.track import load_track

TRACK = load_track("ballasted_60e1")
FREQUENCIES = np.array([0.0, 75.0, 163.0, 500.0, 1060.0, 2500.0])


def test_reciprocity_over_a_bay_and_over_many() -> None:
    for a, b in [(0.0, 0.3), (0.137, 0.52), (0.05, 6.4), (-0.2, 1.0)]:
        forth, back = bloch.receptance(TRACK, FREQUENCIES, a, b), bloch.receptance(TRACK, FREQUENCIES, b, a)
        for one, other in zip(forth, back, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-8)


def test_the_track_repeats_itself_and_is_its_own_mirror_image() -> None:
    here = bloch.receptance(TRACK, FREQUENCIES, 0.137, [0.2, 1.9])
    there = bloch.receptance(TRACK, FREQUENCIES, 0.137 - 3 * 0.6, [0.2 - 3 * 0.6, 1.9 - 3 * 0.6])
    mirrored = bloch.receptance(TRACK, FREQUENCIES, -0.137, [-0.2, -1.9])
    for one, other, reverse in zip(here, there, mirrored, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-8)
        np.testing.assert_allclose(one, reverse, rtol=1e-8)


def test_response_is_smooth_across_sleepers_and_under_the_load() -> None:
    """Both sides of a sleeper and of the load are different branches of the formulas."""
    for place in (0.0, 0.6, 0.25):
        direct, _ = bloch.receptance(TRACK, FREQUENCIES, 0.25, [place - 1e-7, place, place + 1e-7])
        np.testing.assert_allclose(direct[[0, 2]], direct[[1, 1]], rtol=2e-5)


def test_a_passive_track_takes_in_energy() -> None:
    frequencies = np.arange(5.0, 2500.0, 5.0)
    for half in ("symmetric", "antisymmetric"):
        for x in (0.0, 0.11, 0.3):
            assert np.all(bloch.bloch_track(TRACK, half, frequencies).receptance(x, x).imag < 0.0)


@pytest.mark.parametrize("frequency", [-1.0, 2e4, float("nan")])
def test_frequencies_out_of_range_are_refused(frequency: float) -> None:
    with pytest.raises(InputError, match="0 to 10000 Hz"):
        bloch.receptance(TRACK, [frequency], 0.0, 0.0)


def test_positions_outside_the_finite_track_are_refused() -> None:
    with pytest.raises(InputError, match="within 6 m"):
        track_fe.receptance(TRACK, [0.0], 0.0, 6.1, bays=20)
