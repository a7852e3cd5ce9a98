import numpy as np
import pytest

from wheelset_track_sim.track.balance import CHECKED, ORDER, MovingTrack, balanced, gramian, moving_track, serves
from wheelset_track_sim.track.ring import HalfRing, track_ring
from wheelset_track_sim.track.track import load_track

DX = 5e-3


@pytest.fixture(scope="module")
def ring():
    return track_ring(load_track("ballasted_60e1"), DX)


@pytest.fixture(scope="module")
def reduced(ring):
    return balanced(ring.symmetric, ORDER)


def test_gramian_is_the_mean_energy_of_impulse_responses() -> None:
    poles = np.array([-30 + 200j, -80 + 900j])
    inputs = np.array([[1 + 1j, 0.5], [-0.3j, 2.0]])
    t = np.arange(0, 0.5, 1e-5)
    total = np.zeros((4, 4))
    for row in inputs:
        r = np.exp(np.outer(t, poles)) * row
        x = np.concatenate([r.real, r.imag], axis=1)
        total += x.T @ x * 1e-5 / len(inputs)
    assert gramian(poles, inputs) == pytest.approx(total, rel=0.01, abs=1e-5)


@pytest.mark.parametrize("speed", [6.0, 27.8, 80.0])
@pytest.mark.parametrize("start", [0, 60])
@pytest.mark.slow
def test_moving_response_is_that_of_the_ring(ring, reduced, speed: float, start: int) -> None:
    half = ring.symmetric
    modes = reduced.modes(speed)
    assert modes.poles.real.max() < 0
    dt = DX / speed
    steps = np.arange(800)
    found = []
    for poles, inputs, outputs in (
        (half.moving_poles(speed), half.input, half.output),
        (modes.poles, modes.input, modes.output),
    ):
        states = inputs[start] * np.exp(np.outer(steps * dt, poles))
        found.append((outputs[(start + steps) % len(outputs)] * states).real.sum(axis=1))
    assert np.abs(found[1] - found[0]).max() < 5e-4 * found[0].max()


@pytest.mark.slow
def test_more_states_err_less_and_statics_stay(ring, reduced) -> None:
    half = ring.symmetric
    static = half.residual - (half.output * half.input / half.poles).real.sum(axis=1)
    errors = [np.abs(found.compliance() - static).max() for found in (balanced(half, 60), reduced)]
    assert errors[1] < 0.2 * errors[0]
    assert errors[1] < 2e-4 * static.mean()


def test_a_state_is_carried_from_speed_to_speed_and_back(reduced) -> None:
    slow, fast = reduced.modes(10.0), reduced.modes(50.0)
    r = slow.of_state(np.random.default_rng(1).normal(size=ORDER))
    carried = fast.carried(slow, r)
    assert slow.carried(fast, carried) == pytest.approx(r, rel=1e-6, abs=1e-9 * np.abs(r).max())
    # what it deflects is the same at once, whatever the speed
    assert (fast.output @ carried).real == pytest.approx((slow.output @ r).real, rel=1e-6, abs=1e-12)


@pytest.mark.slow
def test_a_half_whose_reduction_grows_or_errs_keeps_the_modes_of_its_ring(ring, reduced) -> None:
    """Ten times the stiffness of the pads and a fifth of their damping: a pole of +8.6 1/s at 100 m/s."""
    shipped = load_track("ballasted_60e1")
    pad = {"stiffness": 10 * shipped.pad.stiffness, "damping": 0.2 * shipped.pad.damping}
    track = load_track({"base": "ballasted_60e1", "name": "stiff", "pad": pad})
    half = track_ring(track, 0.02).antisymmetric
    grown = balanced(half, ORDER)
    assert max(np.linalg.eigvals(grown.rate + v * grown.rate_of_speed).real.max() for v in CHECKED) > 5.0
    assert not serves(grown, half, 0.02)
    assert all(half.modes(v).poles.real.max() == half.poles.real.max() < 0.0 for v in CHECKED)
    assert serves(reduced, ring.symmetric, DX)
    assert not serves(balanced(ring.symmetric, 60), ring.symmetric, DX)  # stable, but 1.5 % off


@pytest.mark.slow
def test_a_track_that_is_not_reduced_runs_from_speed_to_speed() -> None:
    shipped = load_track("ballasted_60e1")
    little = load_track({"base": "ballasted_60e1", "name": "little", "pad": {"damping": 0.01 * shipped.pad.damping}})
    track = moving_track(little, 0.02)
    assert all(isinstance(half, HalfRing) for half in track.halves)
    again = MovingTrack.from_arrays(track.to_arrays())
    slow, fast = (again.symmetric.modes(speed) for speed in (10.0, 100.0))
    state = again.symmetric.standing(3, 1e5)
    static = (slow.output[3] @ slow.of_state(state)).real + again.symmetric.residual[3] * 1e5
    assert static == pytest.approx(1e5 * again.symmetric.compliance()[3], rel=1e-12)
    assert (fast.output[3] @ fast.carried(slow, state)).real == (slow.output[3] @ state).real


def test_round_trip(ring) -> None:
    track = moving_track(load_track("ballasted_60e1"), DX, max_frequency=2000.0, order=40)
    again = MovingTrack.from_arrays(track.to_arrays())
    assert np.array_equal(again.symmetric.rate, track.symmetric.rate)
    with pytest.raises(KeyError):
        MovingTrack.from_arrays({})


def test_a_band_with_fewer_states_than_the_order_keeps_those_that_rounding_leaves():
    half = track_ring(load_track("ballasted_60e1"), 0.01, max_frequency=250.0).symmetric
    reduced = balanced(half, ORDER)
    assert len(reduced.rate) < 2 * len(half.poles) < ORDER
    static = -(half.output * half.input / half.poles).real.sum(axis=1) + half.residual
    assert np.abs(reduced.compliance() - static).max() < 1e-9 * static.max()
    assert (reduced.modes(30.0).poles.real < 0).all()
