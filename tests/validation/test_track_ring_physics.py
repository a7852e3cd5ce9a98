"""The ring in the moving frame against Bloch waves of the infinite track."""

from collections.abc import Iterator

import numpy as np
import pytest

from wheelset_track_sim.dynamics.hold import hold_coefficients
from wheelset_track_sim.track import bloch
from wheelset_track_sim.track.ring import HalfRing, TrackRing, track_ring
from wheelset_track_sim.track.track import HALVES, load_track

pytestmark = pytest.mark.slow

TRACK = load_track("ballasted_60e1")
DX, SPEED, LOAD = 1e-3, 100 / 3.6, 98.1e3


@pytest.fixture(scope="module", autouse=True)
def models(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path_factory.mktemp("models")))
        yield


@pytest.fixture(scope="module")
def ring() -> TrackRing:
    return track_ring(TRACK, DX)


def run(half: HalfRing, forces: np.ndarray, *, speed: float, start: int = 0, standing: float = 0.0) -> np.ndarray:
    """Deflection (n,) under the load, by the recursion of the moving frame; from rest, or from ``standing`` at 0."""
    moving = half.moving_poles(speed)
    dt = DX / (speed or SPEED)
    a, (b0, b1) = np.exp(moving * dt), hold_coefficients(moving, dt)
    q, places, forward = half.standing(0, standing), len(half.residual), 1 if speed else 0
    xi = np.empty(len(forces))
    for n, force in enumerate(forces):
        here = (start + forward * n) % places
        if n:
            before = (start + forward * (n - 1)) % places
            q = a * q + b0 * half.input[before] * forces[n - 1] + b1 * half.input[here] * force
        xi[n] = (half.output[here] @ q).real + half.residual[here] * force
    return xi


def both(ring: TrackRing, forces: np.ndarray, **how: float) -> tuple[np.ndarray, np.ndarray]:
    """Deflection of the loaded and of the opposite rail."""
    even, odd = (run(half, forces / 2, **how) for half in (ring.symmetric, ring.antisymmetric))
    return even + odd, even - odd


def pulse(steps: int, length: int, peak: float) -> np.ndarray:
    forces = np.zeros(steps)
    forces[: length + 1] = peak * np.sin(np.pi * np.arange(length + 1) / length) ** 2
    return forces


def test_statics_are_exact_at_every_position(ring: TrackRing) -> None:
    for place in (0, 1, 37, 75, 299, 300, 513):
        exact = bloch.receptance(TRACK, 0.0, place * DX, place * DX)
        for mine, infinite in zip(ring.receptance(0.0, place), exact, strict=True):
            assert abs(mine[0] - infinite[0, 0]) < 1e-6 * abs(exact[0][0, 0])


def test_standing_state_carries_the_static_deflection(ring: TrackRing) -> None:
    half = ring.symmetric
    at_rest = (half.output[0] @ half.standing(0, LOAD)).real + half.residual[0] * LOAD
    exact = bloch.bloch_track(TRACK, "symmetric", 0.0).receptance(0.0, 0.0)[0, 0].real * LOAD
    assert at_rest == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize(
    ("low", "high", "limit"), [(0, 300, 2e-4), (300, 1000, 0.02), (1150, 2000, 0.025), (2000, 2500, 0.045)]
)
def test_receptance_is_that_of_the_infinite_track(ring: TrackRing, low: float, high: float, limit: float) -> None:
    """Above 1 kHz the error is that of modes beyond 5 kHz taken as static; the pinned-pinned peak is the next test."""
    frequencies = np.arange(low, high, 4.0)
    for place in (0, 137, 300):
        exact = bloch.receptance(TRACK, frequencies, place * DX, place * DX)
        for mine, infinite in zip(ring.receptance(frequencies, place), exact, strict=True):
            assert np.max(np.abs(mine - infinite[0]) / np.abs(exact[0][0])) < limit


def test_more_bays_and_more_modes_converge_to_the_infinite_track() -> None:
    frequencies = np.arange(2.0, 2500.0, 4.0)
    error = []
    for bays, max_frequency in ((80, 5000.0), (160, 5000.0), (160, 7000.0)):
        ring = track_ring(TRACK, 0.02, bays=bays, max_frequency=max_frequency, tolerance=0.0)
        exact = bloch.receptance(TRACK, frequencies, 0.3, 0.3)[0][0]
        error.append(np.abs(ring.receptance(frequencies, 15)[0] - exact) / np.abs(exact))
    peak, high = (frequencies > 1000) & (frequencies < 1150), frequencies > 2000
    assert error[0][peak].max() > 0.1  # the ring is shorter than the pinned-pinned wave lives
    assert error[1][peak].max() < 0.04
    assert error[2][high].max() < 0.5 * error[1][high].max()


def test_standing_harmonic_force_gives_the_receptance(ring: TrackRing) -> None:
    """Time stepping at standstill, 100 ms of run-in, against the exact receptance."""
    dt = DX / SPEED
    t = dt * np.arange(9000)
    settled = t > 0.2
    for frequency, place in ((75.0, 0), (200.0, 300), (620.0, 137)):
        forces = np.cos(2 * np.pi * frequency * t)
        exact = bloch.receptance(TRACK, frequency, place * DX, place * DX)
        for xi, H in zip(both(ring, forces, speed=0.0, start=place), exact, strict=True):
            expected = (H[0, 0] * np.exp(2j * np.pi * frequency * t)).real
            assert np.max(np.abs(xi - expected)[settled]) < 0.01 * abs(exact[0][0, 0])


def test_constant_force_in_motion_is_periodic_with_the_bay(ring: TrackRing) -> None:
    """Static deflection under two wheel loads varies by 32 um along a bay; at 100 km/h it stays near that."""
    xi = run(ring.symmetric, np.full(6000, LOAD), speed=SPEED, standing=LOAD)
    bays = xi.reshape(10, 600)
    assert np.max(np.abs(bays[9] - bays[8])) < 1e-8
    half = bloch.bloch_track(TRACK, "symmetric", 0.0)
    static = np.array([half.receptance(x, x)[0, 0].real for x in np.arange(60) * 0.01]) * LOAD
    assert np.ptp(static) == pytest.approx(32e-6, abs=1e-6)
    assert bays[9].mean() == pytest.approx(static.mean(), rel=0.01)
    assert 25e-6 < np.ptp(bays[9]) < 45e-6


def test_there_is_no_ripple_at_the_rate_of_the_elements(ring: TrackRing) -> None:
    """Eight elements a bay would show at eight times the bay's rate, 370 Hz at 100 km/h."""
    half = bloch.bloch_track(TRACK, "symmetric", 0.0)
    static = np.array([half.receptance(x, x)[0, 0].real for x in np.arange(100) * 0.006]) * LOAD
    xi = run(ring.symmetric, np.full(2400, LOAD), speed=SPEED, standing=LOAD)[-600:]
    limits = {}
    for name, samples in (("static", static), ("moving", xi)):
        limits[name] = np.abs(np.fft.rfft(samples)) / len(samples)
    for harmonic in (8, 16):
        assert limits["moving"][harmonic] < 2 * limits["static"][harmonic] + 1e-5 * limits["static"][0]


@pytest.mark.parametrize("start", [0, 300])
def test_moving_pulse_is_the_convolution_with_moving_greens_functions(ring: TrackRing, start: int) -> None:
    """Eq. (3) on exact receptances: the response where the load is, to all forces where it has been.

    The pulse of 4 ms has no content beyond 2500 Hz that counts, so the band limit does not show.
    """
    length, dt = 112, DX / SPEED
    forces = pulse(1201, length, 1e5)
    spacing = 4.0
    frequencies = np.arange(0.0, 2500.0 + spacing, spacing)
    responses = np.array([20, 60, 112, 160, 300, 700, 1200])
    weights = np.where(frequencies == 0.0, 1.0, 2.0) * spacing
    steps = np.arange(0, length + 1, 8)
    expected = np.zeros((2, responses.size))
    halves = [bloch.bloch_track(TRACK, half, frequencies) for half in HALVES]
    for step in steps:
        even, odd = (half.receptance((start + step) * DX, (start + responses) * DX) for half in halves)
        rotation = np.exp(2j * np.pi * frequencies * (responses[:, None] - step) * dt) * weights
        for rail, H in enumerate((even + odd, even - odd)):
            expected[rail] += 8 * dt * forces[step] * np.sum((H / 2 * rotation).real, axis=1)
    for rail, xi in enumerate(both(ring, forces, speed=SPEED, start=start)):
        np.testing.assert_allclose(xi[responses], expected[rail], atol=2e-3 * np.abs(expected[0]).max())


def test_length_of_the_ring_does_not_matter_to_an_impact(ring: TrackRing) -> None:
    """Impact of 200 kN and 2 ms at mid-span: 1.1 mm; default ring against 200 bays with all modes to 5 kHz."""
    forces = pulse(3000, 56, 2e5)
    long = track_ring(TRACK, DX, bays=200, tolerance=0.0)
    for mine, infinite in zip(
        both(ring, forces, speed=SPEED, start=300), both(long, forces, speed=SPEED, start=300), strict=True
    ):
        assert np.max(np.abs(mine - infinite)) < 0.2e-6


def test_early_response_to_a_fast_front(ring: TrackRing) -> None:
    """Smooth step of 0.3 ms at standstill against exact receptances to 10 kHz: modes and residual share it rightly."""
    dt, rise = 4e-6, 3e-4
    spacing = 5.0
    frequencies = np.arange(0.0, 10000.0, spacing)
    omega = 2 * np.pi * frequencies
    t = dt * np.arange(400)
    force = np.where(t < 2 * rise, np.sin(np.pi * t / (2 * rise)) ** 2, 0.0)  # a pulse of twice the rise
    spectrum = (np.exp(-1j * np.outer(omega, t)) * force).sum(axis=1) * dt
    H = bloch.receptance(TRACK, frequencies, 0.3, 0.3)[0][0]
    weights = np.where(frequencies == 0.0, 1.0, 2.0) * spacing
    exact = (np.exp(1j * np.outer(t, omega)) @ (H * spectrum * weights)).real
    mine = np.zeros_like(t)
    for half in (ring.symmetric, ring.antisymmetric):
        a, (b0, b1) = np.exp(half.poles * dt), hold_coefficients(half.poles, dt)
        q = np.zeros_like(half.poles)
        for n in range(len(t)):
            if n:
                q = a * q + half.input[300] * (b0 * force[n - 1] + b1 * force[n])
            mine[n] += ((half.output[300] @ q).real + half.residual[300] * force[n]) / 2
    assert np.max(np.abs(mine - exact)) < 0.005 * exact.max()
    early = t < rise
    assert np.max(np.abs(mine - exact)[early]) < 0.01 * exact[early].max()
