"""Conditions of contact, spelled out with every element's influence on every other: apart from any solver's way."""

import numpy as np

from wheelset_track_sim.contact import ContactPatch
from wheelset_track_sim.contact.law_kernels import ContactLaw


def assert_contact_conditions(law: ContactLaw, gap: np.ndarray, patch: ContactPatch, compliance: float) -> None:
    """Eqs (8), (10), (12): elements that bear touch, the others are apart, and the pressures add up to the force."""
    i, j = (index.ravel() for index in np.indices(gap.shape))
    bears = patch.pressure.ravel() > 0
    p = patch.pressure.ravel()[bears]
    influence = law.influence[abs(i[:, None] - i[bears]), abs(j[:, None] - j[bears])]
    distance = gap.ravel() + influence @ p - (patch.approach - compliance * patch.force)
    assert (patch.pressure >= 0).all()
    assert np.abs(distance[bears]).max() < 1e-13
    assert distance[~bears].min() > -1e-13
    np.testing.assert_allclose(patch.force, p.sum() * law.element_area, rtol=1e-12)
