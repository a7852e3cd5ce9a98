"""The half-space solver of ContactMechanics on the elements of this package."""

import numpy as np
import pytest
from numpy.typing import NDArray

from wheelset_track_sim.contact.law import ELEMENT_WIDTH

DX = 0.001
Real = NDArray[np.float64]


def half_space(gap: Real, contact_modulus: float, force: float) -> tuple[Real, float]:
    """Pressure, Pa, on elements of DX x ELEMENT_WIDTH and approach, m, under ``force`` by Polonsky and Keer's method.

    The force is given, not the approach: at a given approach the method can cycle. Lengths are in elements, stresses in
    E*. Skip the test if ContactMechanics is not installed: it is imported here, since that takes half a second.
    """
    contact_mechanics = pytest.importorskip("ContactMechanics")
    topography = pytest.importorskip("SurfaceTopography")
    nx, ny = gap.shape
    size = (float(nx), ny * ELEMENT_WIDTH / DX)
    substrate = contact_mechanics.FreeFFTElasticHalfSpace((nx, ny), 1.0, size)
    # Where there is no rail the surface is out of reach.
    surface = topography.Topography(-np.minimum(gap, 0.1) / DX, size)
    system = contact_mechanics.make_system(substrate=substrate, surface=surface)
    result = system.minimize_proxy(
        external_force=force / (contact_modulus * DX**2), pentol=1e-9, forcetol=1e-9, maxiter=3000
    )
    assert result.success
    return np.asarray(result.jac)[:nx, :ny] * contact_modulus * DX / ELEMENT_WIDTH, result.offset * DX
