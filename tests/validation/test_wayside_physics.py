"""What a detector reads against statics, against receptances, and against the track stepped in time."""

import numpy as np
import pytest

from wheelset_track_sim.dynamics.hold import hold
from wheelset_track_sim.track import bloch
from wheelset_track_sim.track.bloch import bloch_track
from wheelset_track_sim.track.influence import influence_line
from wheelset_track_sim.track.ring import track_ring
from wheelset_track_sim.track.track import HALVES, load_track
from wheelset_track_sim.wayside.detector import Detector, RailAcceleration, RailDisplacement, SeatForce, ShearBridge
from wheelset_track_sim.wayside.history import wayside_reading

TRACK = load_track("ballasted_60e1")
L = TRACK.spacing


def influence(quantity, place, x, frequencies=0.0, track=TRACK):
    """Reading (2, positions, frequencies) of a place in bay 0 for unit forces on its own rail and on the other one."""
    halves = []
    for half in HALVES:
        line = influence_line(bloch_track(track, half, frequencies), half, quantity, place, -30, 30)
        bays = np.floor(np.asarray(x) / L + 1e-9).astype(int)
        halves.append([line.at(bay, at - bay * L) for bay, at in zip(bays, x, strict=True)])
    even, odd = np.array(halves)
    return np.array([even + odd, even - odd]) / 2


@pytest.mark.parametrize("name", ["ballasted_60e1", "slab_60e1"])
def test_the_difference_of_static_shear_is_the_force_between_and_nothing_outside(name):
    """To 1e-5, on both sides of both gauges; a force on the other rail gives nothing."""
    x = np.array([-6.0, -0.5, 0.05, 0.149, 0.151, 0.3, 0.449, 0.451, 0.6, 0.9, 7.2])
    first, second = (influence("shear", place, x, track=load_track(name)) for place in (0.15, 0.45))
    own, other = (first - second)[..., 0].real
    np.testing.assert_allclose(own, (x > 0.15) & (x < 0.45), atol=1e-5)
    np.testing.assert_allclose(other, 0.0, atol=1e-5)


def test_deflections_are_receptances_and_reciprocal():
    frequencies = np.array([0.0, 40.0, 163.0, 1073.0, 2500.0])
    x = np.array([-2.95, 0.1, 0.3, 0.42, 4.8])
    found = influence("deflection", 0.42, x, frequencies)
    for ours, theirs in zip(found, bloch.receptance(TRACK, frequencies, 0.42, x), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9)
    back = influence("deflection", 0.1, [0.42], frequencies)
    np.testing.assert_allclose(found[:, 1], back[:, 0], rtol=1e-9)


def test_the_static_moment_is_the_curvature_of_the_deflection():
    """Between load and supports the shear force is constant, so that M = EI theta' = EI w''."""
    h, x_load = 2e-3, np.array([0.31, 1.3, -0.7])
    places = 0.2 + h * np.array([-1, 0, 1])
    w = np.array([bloch.receptance(TRACK, 0.0, at, places)[0][:, 0].real for at in x_load])
    curvature = (w[:, 0] - 2 * w[:, 1] + w[:, 2]) / h**2
    moment = influence("moment", 0.2, x_load)[0, :, 0].real
    np.testing.assert_allclose(moment, TRACK.rail.EI * curvature, rtol=2e-4, atol=1e-5)


def test_the_seats_carry_the_load_together():
    x = 0.37 + L * np.arange(-30, 30)
    own, other = influence("seat_force", 0.0, x)[..., 0].real.sum(axis=1)
    assert own + other == pytest.approx(1.0, abs=1e-6)


def test_a_slow_load_draws_the_static_influence_line():
    """At 5 m/s inertia and dampers add less than 1 % of the deflection under the load."""
    detector = Detector("w", (RailDisplacement("w", "rail_1", 0.3),), rate=2e3, band=500.0, reach=1.8)
    reading = wayside_reading(detector, TRACK, 6.0, np.full((9000, 2), 1e5), speed=5.0)
    static = -1e5 * influence("deflection", 0.3, reading.places[::40] - 6.0)[..., 0].real.sum(axis=0)
    np.testing.assert_allclose(reading.values[::40, 0], static, atol=0.01 * np.abs(static).max())


@pytest.fixture(scope="module")
def impact():
    """Forces (steps, 2) N: the static load, and a hit of 2 ms with 200 kN on rail 1 above a sleeper at 7.2 m."""
    forces = np.full((8500, 2), 98.1e3)
    forces[:, 0] += 2e5 * np.exp(-(((np.arange(8500) - 7200) / 30.0) ** 2))
    return forces


def test_accelerations_are_second_differences_of_displacements(impact):
    """To 2 % of their peak, where the rate is twenty times the band."""
    channels = (RailDisplacement("w", "rail_1", 1.2), RailAcceleration("a", "rail_1", 1.2))
    detector = Detector("both", channels, rate=40e3, band=2e3, reach=0.3)
    reading = wayside_reading(detector, TRACK, 6.0, impact, speed=25.0)
    differences = np.diff(reading.channel("w"), 2) * detector.rate**2
    a = reading.channel("a")[1:-1]
    assert np.abs(differences - a).max() < 0.02 * np.abs(a).max()


def test_displacements_are_those_of_the_ring_stepped_in_time(impact):
    """Modes of a ring of 80 bays, driven by the moving forces and watched from a place that does not move."""
    speed, place, steps = 25.0, 7.5, round(L / 1e-3)
    detector = Detector("w", (RailDisplacement("w", "rail_1", 1.5), RailDisplacement("v", "rail_2", 1.5)), reach=0.6)
    reading = wayside_reading(detector, TRACK, 6.0, impact, speed=speed)
    ring = track_ring(TRACK, 1e-3)
    dt = 1e-3 / speed
    found = []
    for half, force in ((ring.symmetric, impact.sum(axis=1) / 2), (ring.antisymmetric, np.subtract(*impact.T) / 2)):
        a, b0, b1 = hold(half.moving_poles(speed), dt)
        r = half.standing(0, force[0])
        watched = np.empty(len(force))
        inside = round((place % L) / 1e-3)
        for step, now in enumerate(force):
            if step:
                r = a * r + b0 * half.input[(step - 1) % steps] * force[step - 1] + b1 * half.input[step % steps] * now
            phase = np.exp(1j * half.wavenumbers * (place - step * 1e-3))
            watched[step] = (half.output[inside] * phase * r).sum().real
        found.append(watched)
    for channel, watched in (("w", found[0] + found[1]), ("v", found[0] - found[1])):
        far = np.abs(reading.places - place) > 0.1  # without the static residual of modes left out
        expected = -np.interp(reading.places, np.arange(len(watched)) * 1e-3, watched)
        error = np.abs(reading.channel(channel) - expected)[far].max()
        assert error < 0.005 * np.abs(expected).max()


def test_a_load_that_stands_on_a_bridge_is_read_within_the_inertia_of_the_rail():
    channels = (ShearBridge("q", "rail_1", 0.3), SeatForce("s", "rail_1", 0.0))
    slow = wayside_reading(
        Detector("q", channels, rate=2e3, band=500.0), TRACK, 6.0, np.full((8000, 2), 1e5), speed=5.0
    )
    on = np.abs(slow.places - 6.3) < 0.1
    np.testing.assert_allclose(slow.channel("q")[on], 1e5, rtol=1e-3)
    static = 1e5 * influence("seat_force", 0.0, slow.places[::40] - 6.0)[..., 0].real.sum(axis=0)
    np.testing.assert_allclose(slow.channel("s")[::40], static, atol=0.01 * static.max())
