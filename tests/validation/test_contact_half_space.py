"""The active set against the FFT half-space solver of ContactMechanics, with a defect in the patch."""

import numpy as np
import pytest

from support.half_space import half_space
from wheelset_track_sim.contact import ContactGeometry, build_contact_law, solve_patch
from wheelset_track_sim.contact.law_kernels import total_separation
from wheelset_track_sim.irregularities import Breakout

pytestmark = pytest.mark.slow

DX = 0.001


@pytest.mark.parametrize(
    ("defect", "tread"),
    [
        (Breakout("wheel_1", 0.030, 0.024, 0.002), 0),
        (Breakout("wheel_1", 0.030, 0.024, 0.002), 22),
        (Breakout("wheel_1", 0.010, 0.008, 0.0003), 0),
        (Breakout("wheel_1", 0.010, 0.008, 0.0003), 6),
        (Breakout("wheel_1", 0.020, 0.010, 0.0006, y=0.004), 5),
        (Breakout("wheel_1", 0.020, 0.010, 0.0006, y=0.004), 500),
    ],
)
@pytest.mark.parametrize("depth", [1e-4, 2.5e-4])
def test_pressure_agrees(defect, tread, depth):
    geometry = ContactGeometry()
    law = build_contact_law([defect], geometry, DX, 2713, tables=False)
    gap = total_separation(law, 0, tread, 0)
    approach = gap.min() + depth
    patch = solve_patch(law, 0, tread, 0, approach)
    other, its_approach = half_space(gap, geometry.contact_modulus, patch.force)
    assert patch.force > 10e3
    assert np.abs(patch.pressure - other).max() < 1e-6 * other.max()
    assert its_approach == pytest.approx(approach, rel=1e-7)
