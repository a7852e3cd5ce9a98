import dataclasses
import math

import numpy as np
import pytest

from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.summary import combine, statistics, summarise


def uniaxial(forces: list[tuple[float, float]], stress: list[float]) -> SampleBlock:
    stresses = np.zeros((len(stress), 1, 6))
    stresses[:, 0, 1] = stress
    return SampleBlock(5, 0.1, 1e-3, 10.0, 0.05, 0, np.array(forces), stresses, ("A1",))


def test_scalars_of_a_block():
    found = summarise(uniaxial([(3.0, 1.0), (0.0, 1.0), (4.0, 1.0), (0.0, 1.0)], [2.0, 7.0, -5.0, 1.0]))
    wheel_1, wheel_2 = found.wheels
    assert found.samples == 4
    assert (wheel_1.max_force, wheel_1.min_force, wheel_1.mean_force) == (4.0, 0.0, 1.75)
    assert wheel_1.rms_force == pytest.approx(2.5, rel=1e-15)
    assert wheel_1.contact_loss == pytest.approx(2e-3, rel=1e-15)
    assert dataclasses.astuple(wheel_2) == (1.0, 1.0, 1.0, 1.0, 0.0)
    (node,) = found.nodes
    assert node.name == "A1"
    assert node.max_principal == pytest.approx(7.0, rel=1e-12)
    assert node.min_principal == pytest.approx(0.0, abs=1e-12)  # compression: the largest principal stress is zero
    assert node.mean_principal == pytest.approx(2.5, rel=1e-12)
    assert node.rms_principal == pytest.approx(math.sqrt(54 / 4), rel=1e-12)


def test_statistics_of_signals():
    found = statistics(np.array([[2.0, 7.0, -5.0], [1.0, 1.0, 1.0]]))
    np.testing.assert_array_equal(found.max, [7.0, 1.0])
    np.testing.assert_array_equal(found.min, [-5.0, 1.0])
    np.testing.assert_allclose(found.mean, [4 / 3, 1.0], rtol=1e-15)
    np.testing.assert_allclose(found.rms, [math.sqrt(26), 1.0], rtol=1e-15)


def test_parts_combine_to_the_whole(make_block):
    whole = make_block(0, 1000)
    cuts = [(0, 1), (1, 33), (33, 1000)]
    parts = [
        dataclasses.replace(whole, forces=whole.forces[a:b].copy(), stresses=whole.stresses[a:b].copy())
        for a, b in cuts
    ]
    found, expected = combine(summarise(part) for part in parts), summarise(whole)
    assert found.samples == expected.samples
    for one, other in zip(found.nodes, expected.nodes, strict=True):
        assert dataclasses.astuple(one)[:3] == dataclasses.astuple(other)[:3]
        assert dataclasses.astuple(one)[3:] == pytest.approx(dataclasses.astuple(other)[3:], rel=1e-12)
    for one, other in zip(found.wheels, expected.wheels, strict=True):
        assert dataclasses.astuple(one) == pytest.approx(dataclasses.astuple(other), rel=1e-12)


def test_nothing_has_no_summary():
    with pytest.raises(ValueError, match="nothing to combine"):
        combine([])
