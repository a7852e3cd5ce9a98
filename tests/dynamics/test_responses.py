import numpy as np
import pytest

from wheelset_track_sim.dynamics.responses import green_function, receptance
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.track import bloch
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wheelset.kinds import load_wheelset, reduce_wheelset


def test_a_track_has_the_receptance_of_its_bloch_waves():
    track = load_track("ballasted_60e1")
    f = np.array([0.0, 75.0, 400.0, 1073.0])
    H = receptance(track, f, load_at=0.3, response_at=0.6)
    direct, cross = bloch.receptance(track, f, 0.3, 0.6)
    assert H.shape == (4, 2, 2)
    np.testing.assert_array_equal(H[:, 0, 0], direct[0])
    np.testing.assert_array_equal(H[:, 1, 0], cross[0])
    np.testing.assert_array_equal(H, np.swapaxes(H, 1, 2))
    assert receptance(track, 0.0)[0, 0, 0].real == pytest.approx(1.1123e-8, rel=1e-3)  # docs/validation.md


def test_a_wheelset_is_reciprocal_and_above_its_first_resonance_a_mass():
    H = receptance(load_wheelset("x40"), np.array([0.0, 25.0, 206.0]))
    np.testing.assert_allclose(H, np.swapaxes(H, 1, 2), rtol=1e-6)
    rigid = H[1].sum()  # both wheels, both forces: 4 times that of the whole wheelset over m omega^2
    assert rigid.real == pytest.approx(-4 / (1942.4 * (2 * np.pi * 25.0) ** 2), rel=0.12)


@pytest.mark.slow
def test_the_green_function_of_a_wheelset_is_the_sum_of_its_modes():
    """In the middle of the band the transform meets the closed form, Re(c b exp(lambda t)) of each pole."""
    model = reduce_wheelset(load_wheelset("x40"))
    times, G = green_function(load_wheelset("x40"), duration=4.0, dt=5e-5, max_frequency=10e3)
    exact = np.zeros_like(G)
    for pole, into, out in zip(model.poles, model.inputs, model.outputs.T, strict=True):
        exact += (np.exp(pole * times) * np.outer(out, into)[..., None]).real
    late = times > 0.02
    assert np.abs(G - exact)[..., late].max() < 2e-3 * np.abs(exact).max()


@pytest.mark.slow
@pytest.mark.parametrize("model", [load_track("ballasted_60e1"), load_wheelset("trailer_calculix")])
def test_the_green_function_adds_up_to_the_static_receptance(model):
    times, G = green_function(model, duration=4.0, dt=2e-4)
    total = (G[..., 1:].sum(axis=-1) + G[..., 0] / 2) * (times[1] - times[0])
    static = receptance(model, 0.0)[0].real
    np.testing.assert_allclose(total, static, atol=0.02 * np.abs(static).max())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"duration": 1.0, "dt": 1e-3}, "max_frequency = 2500 Hz is out of range: give up to 500 Hz"),
        ({"duration": 1.0, "dt": 0.0}, "max_frequency"),
        ({"duration": 1e-4, "dt": 1e-4}, "duration = 0.0001 s"),
    ],
)
def test_what_makes_no_sense_is_refused(options, words):
    with pytest.raises(InputError, match=words):
        green_function(load_track("ballasted_60e1"), **options)
    with pytest.raises(InputError, match="frequencies"):
        receptance(load_track("ballasted_60e1"), [-1.0])
