"""The discretised contact against Hertz's theory, on a crown of one radius."""

import numpy as np
import pytest

from wheelset_track_sim.contact import (
    ContactGeometry,
    HertzContact,
    ProfilePair,
    RailHead,
    build_contact_law,
    solve_patch,
)
from wheelset_track_sim.contact.law import ELEMENT_WIDTH

ROUND = ContactGeometry(pairs=(ProfilePair(rail=RailHead(radii=(0.3,), ends=(0.036,))),) * 2)
HERTZ = HertzContact(ROUND.wheel_radius, 0.3, ROUND.contact_modulus)


def errors(geometry, dx, force, dy=None):
    law = build_contact_law([], geometry, dx, round(2.713 / dx), dy=dy or dx, tables=False)
    patch = solve_patch(law, 0, 0, 0, HERTZ.approach(force))
    return patch.force / force - 1, patch.pressure.max() / HERTZ.peak_pressure(force) - 1


@pytest.mark.parametrize("geometry", [ROUND, ContactGeometry()], ids=["round", "60E1"])
@pytest.mark.parametrize("force", [20e3, 60e3, 100e3, 200e3, 350e3])
def test_force_and_peak_pressure_on_the_production_grid(geometry, force):
    in_force, in_pressure = errors(geometry, 0.001, force, ELEMENT_WIDTH)
    assert abs(in_force) < 0.002
    assert abs(in_pressure) < 0.01


def test_stiffness_is_that_of_hertz():
    law = build_contact_law([], ROUND, 0.0005, 5426, dy=0.0005, tables=False)
    patch = solve_patch(law, 0, 0, 0, HERTZ.approach(100e3))
    assert patch.stiffness == pytest.approx(1.5 * 100e3 / HERTZ.approach(100e3), rel=0.01)


def test_converges_with_the_grid():
    coarse = np.mean([abs(errors(ROUND, 0.002, force)[0]) for force in np.linspace(80e3, 120e3, 9)])
    fine = np.mean([abs(errors(ROUND, 0.0005, force)[0]) for force in np.linspace(80e3, 120e3, 9)])
    assert fine < coarse / 4
