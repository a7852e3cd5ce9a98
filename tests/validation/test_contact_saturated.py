"""Contact with a hardness against published codes, closed bounds and finer elements: a sphere on a half-space."""

import numpy as np
import pytest
from scipy.optimize import brentq

from wheelset_track_sim.contact.active_set_kernels import CONVERGED, solve_active_set
from wheelset_track_sim.contact.hertz import HertzContact
from wheelset_track_sim.contact.influence import contact_modulus, influence_table
from wheelset_track_sim.contact.yielding_kernels import solve_yielding

RADIUS, HARDNESS = 0.36, 1.2e9
MODULUS = contact_modulus(210e9, 0.3)

TAMAAS = {
    100e3: (60, 484, [1191.32007, 1129.18916, 1070.43633, 998.98128, 911.38430, 802.04137, 660.37171, 463.49623]),
    150e3: (276, 648, [1187.51999, 1008.78994, 869.75679, 700.48784, 447.91216]),
    250e3: (688, 952, [898.73596, 583.21125]),
}
"""``KatoSaturated`` of tamaas 2.9.0 (L. Frerot, G. Anciaux, V. Rey, S. Pham-Ba, J.-F. Molinari, J. Open Source Software
5 (2020) 2121): elements that yield, in contact, and the elastic pressures outwards along the middle row, MPa.

64 x 64 elements of 0.5 mm, none on the axis; operator ``dcfft``, lengths in 32 mm, pressures in E*, tolerance 1e-14.
"""


def sphere(cells, width):
    x = (np.arange(cells) - cells / 2 + 0.5) * width
    return (x[:, None] ** 2 + x**2) / (2 * RADIUS), influence_table(cells, cells, width, width, 210e9, 0.3)


def pressure_at(gap, influence, width, approach, hardness=HARDNESS):
    pressure, in_contact = np.empty(gap.shape), np.zeros(gap.shape, bool)
    of_elements = gap, False, influence, width**2, approach, 0.0
    assert solve_active_set(*of_elements, in_contact, pressure)[2] == CONVERGED
    assert solve_yielding(*of_elements, hardness, in_contact, pressure)[2] == CONVERGED
    return pressure


@pytest.mark.parametrize("force", TAMAAS)
def test_pressures_are_those_of_tamaas(force):
    width = 5e-4
    gap, influence = sphere(64, width)
    elastic = HertzContact(RADIUS, RADIUS, MODULUS).approach(force)
    approach = brentq(
        lambda each: pressure_at(gap, influence, width, each).sum() * width**2 - force, elastic, 2 * elastic, rtol=1e-13
    )
    pressure = pressure_at(gap, influence, width, approach)
    yields, in_contact, edge = TAMAAS[force]
    assert (pressure == HARDNESS).sum() == yields
    assert (pressure > 0).sum() == in_contact
    row = pressure[32, 32:]
    np.testing.assert_allclose(row[(row > 0) & (row < HARDNESS)] / 1e6, edge, atol=1e-4)


def test_below_yield_it_is_hertz():
    width = 5e-4
    gap, influence = sphere(48, width)
    hertz = HertzContact(RADIUS, RADIUS, MODULUS)
    pressure = pressure_at(gap, influence, width, hertz.approach(60e3))
    assert hertz.peak_pressure(60e3) < HARDNESS
    assert pressure.sum() * width**2 == pytest.approx(60e3, rel=2e-3)


@pytest.mark.slow
def test_force_converges_with_the_elements():
    """From elements of 1 mm, which the software runs on, to a quarter of it: within 0.2 %."""
    forces = []
    for divided in (1, 2, 4):
        width = 1e-3 / divided
        forces.append(pressure_at(*sphere(28 * divided, width), width, 1.5e-4).sum() * width**2)
    assert forces[0] == pytest.approx(forces[2], rel=3e-3)
    assert abs(forces[1] - forces[2]) < 1e-3 * forces[2]


def test_deep_indentation_tends_to_hardness_times_overlap():
    """A sphere of a soft material: 2 pi R delta is the area of its overlap."""
    width, hardness, approach = 5e-4, 2e7, 1e-4
    gap, influence = sphere(48, width)
    force = pressure_at(gap, influence, width, approach, hardness).sum() * width**2
    assert force == pytest.approx(hardness * 2 * np.pi * RADIUS * approach, rel=0.02)
