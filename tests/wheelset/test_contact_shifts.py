import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.stress_node import StressNode

SHIFTS = (-0.010, -0.006)


@pytest.mark.slow
def test_the_axle_bends_by_the_arms_of_the_forces():
    """Bending of a beam on the axle boxes: what a shift of the contacts changes of the stress on the axle's top."""
    x40 = load_wheelset("x40")
    places = (-0.4, 0.0, 0.2)
    x40 = dataclasses.replace(x40, stress_nodes=tuple(StressNode(f"n{i}", y=y) for i, y in enumerate(places)))
    shifted = dataclasses.replace(x40, contact_shifts=SHIFTS)
    assert shifted.contact_positions == (-0.760, 0.744)
    before, after = (build_reduced_wheelset(each, max_frequency=1500.0).static_stress() for each in (x40, shifted))
    box, diameter = x40.axle_boxes.distance, 0.180
    section = np.pi * diameter**3 / 32
    for wheel, (contact, shift) in enumerate(zip(x40.contact_positions, SHIFTS, strict=True)):
        for node, y in enumerate(places):
            # Between two supports, 1 N at c bends at y by the product of the distances to the nearer supports.
            arms = [(box + min(c, y)) * (box - max(c, y)) / (2 * box) for c in (contact, contact + shift)]
            expected = (arms[1] - arms[0]) / section
            found = after[node, 1, wheel] - before[node, 1, wheel]
            assert found == pytest.approx(expected, rel=0.03, abs=10.0)


def test_shifts_beside_the_tread_are_refused():
    with pytest.raises(InputError, match=r"contact_shifts has 0\.05 m: give distances .* up to 0\.035 m"):
        dataclasses.replace(load_wheelset("x40"), contact_shifts=(0.0, 0.05))
