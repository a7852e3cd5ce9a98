import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.bags import Bag, BagWriter, State, blocks, read_bag
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.summary import summarise

START_NS = 1_700_000_000_123_456_789


@pytest.fixture(params=["run.mcap", "run"], ids=["file", "folder"])
def path(request, tmp_path):
    return tmp_path / "made on the way" / request.param


def same(left, right) -> bool:
    if isinstance(left, np.ndarray):
        return left.dtype == right.dtype and left.shape == right.shape and left.tobytes() == right.tobytes()
    return left == right


def assert_equal_blocks(found: list[SampleBlock], given: list[SampleBlock]) -> None:
    assert len(found) == len(given)
    for one, other in zip(found, given, strict=True):
        for field in dataclasses.fields(SampleBlock):
            assert same(getattr(one, field.name), getattr(other, field.name)), field.name


def test_blocks_come_back_bit_by_bit(path, run_info, run_blocks):
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        for block in run_blocks:
            bag.write(block)
    assert_equal_blocks(list(blocks(path)), run_blocks)


def test_awkward_bits_survive(path, run_info, make_block):
    block = make_block(2**63 + 5, 3)
    forces = np.array([[-0.0, 5e-324], [9e29, 0.1], [np.nextafter(1, 2), 1 / 3]])
    block = dataclasses.replace(block, forces=forces)
    with BagWriter(path, run_info, start_ns=0) as bag:
        bag.write(block)
    assert_equal_blocks(list(blocks(path)), [block])


@pytest.mark.parametrize("nodes", [(), ("A1",), ("Journal fillet 2", "x", "B1")])
def test_any_stress_nodes(path, run_info, make_block, nodes):
    given = [make_block(0, 10, nodes=nodes), make_block(10, 20, nodes=nodes)]
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        for block in given:
            bag.write(block)
    assert_equal_blocks(list(blocks(path)), given)


def test_recording_has_one_entry_a_step(path, run_info, run_blocks, make_state):
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        bag.write_state(make_state(run_blocks[0]))
        for block in run_blocks[:2]:
            bag.write(block)
        bag.write_state(make_state(run_blocks[2]))
        bag.write(run_blocks[2])
    found = read_bag(path)
    first, _, third = run_blocks
    assert found.info == run_info
    assert found.start_ns == START_NS
    assert found.states == (make_state(first), make_state(third))
    assert found.nodes == first.nodes
    assert same(found.steps, np.arange(2090, dtype=np.uint64))
    assert same(found.forces, np.concatenate([block.forces for block in run_blocks]))
    assert same(found.stresses, np.concatenate([block.stresses for block in run_blocks]))
    np.testing.assert_allclose(found.position, np.arange(2090) * 1e-3, rtol=1e-13)
    np.testing.assert_allclose(
        np.diff(found.time), np.repeat([first.step_period, third.step_period], [1390, 699]), rtol=1e-9
    )
    assert np.count_nonzero(found.revision == 1) == np.count_nonzero(found.speed == third.speed) == len(third)
    assert found.max_principal.shape == (2090, 3)


def test_summary_of_a_recording_is_that_of_its_blocks(path, run_info, make_block):
    whole = make_block(0, 2000)
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        for a, b in ((0, 7), (7, 1396), (1396, 2000)):
            bag.write(
                dataclasses.replace(
                    whole,
                    first_step=a,
                    time=a * whole.step_period,
                    position=a * 1e-3,
                    forces=whole.forces[a:b].copy(),
                    stresses=whole.stresses[a:b].copy(),
                )
            )
    assert read_bag(path).summary == summarise(whole)


def test_events_keep_their_order(path, run_info, run_blocks, make_state):
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        for block in run_blocks:
            bag.write_state(make_state(block))
            bag.write(block)
    kinds = [type(event) for event in Bag(path).events()]
    assert kinds == [State, SampleBlock] * 3


def test_versions_tell_what_computed_the_run(path, run_info, run_blocks):
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        bag.write(run_blocks[0])
    versions = Bag(path).info.versions
    assert versions["numpy"] == np.__version__
    assert {"wheelset_track_sim", "python", "scipy", "numba"} <= versions.keys()
