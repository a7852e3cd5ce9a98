"""Influence lines of one place, at frequencies that decay too."""

import numpy as np
import pytest

from wheelset_track_sim.track.bloch import bloch_track
from wheelset_track_sim.track.influence import influence_line
from wheelset_track_sim.track.track import HALVES, load_track

TRACK = load_track("ballasted_60e1")
FREQUENCIES = np.array([0.0, 75.0, 1073.0, 4000.0])


@pytest.mark.parametrize("half", HALVES)
@pytest.mark.parametrize("decay", [0.0, 3.0])
@pytest.mark.parametrize("place", [0.0, 0.23])
def test_a_deflection_is_the_receptance_from_there(half, decay, place):
    waves = bloch_track(TRACK, half, FREQUENCIES - 1j * decay)
    line = influence_line(waves, half, "deflection", place, -4, 4)
    for bay, x in ((0, 0.1), (0, 0.23), (0, 0.5), (3, 0.3), (-4, 0.0)):
        [expected] = waves.receptance(place, [bay * TRACK.spacing + x])
        np.testing.assert_allclose(line.at(bay, x), expected, rtol=1e-9)


def test_shear_jumps_by_the_force_at_the_gauge_and_counts_half_on_it():
    waves = bloch_track(TRACK, "symmetric", FREQUENCIES)
    line = influence_line(waves, "symmetric", "shear", 0.2, -1, 1)
    before, on, behind = (line.at(0, x) for x in (0.2 - 2e-9, 0.2, 0.2 + 2e-9))
    np.testing.assert_allclose(behind - before, 1.0, atol=1e-6)
    np.testing.assert_allclose(on, (before + behind) / 2, atol=1e-6)


def test_the_sleeper_moves_by_its_receptance_times_the_seat_force():
    waves = bloch_track(TRACK, "symmetric", FREQUENCIES)
    force, sleeper, rail = (
        influence_line(waves, "symmetric", quantity, 0.0, -2, 2).at(1, 0.3)
        for quantity in ("seat_force", "sleeper_deflection", "deflection")
    )
    omega = 2 * np.pi * FREQUENCIES
    pad = TRACK.pad.stiffness + 1j * omega * TRACK.pad.damping
    np.testing.assert_allclose(pad * (rail - sleeper), force, rtol=1e-9)
