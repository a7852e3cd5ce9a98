"""Parts of a run by time and step: the same bits as in the whole, read from a few chunks."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from wheelset_track_sim.bags import Bag, BagWriter, Gap, blocks, read_bag
from wheelset_track_sim.bags.mcap.reader import McapReader
from wheelset_track_sim.bags.window import RunWindow, first_chunk
from wheelset_track_sim.errors import InputError, RecordingError

CHUNKS = 40
LENGTH = 25
STEPS = CHUNKS * LENGTH


@pytest.fixture(scope="module")
def bag(tmp_path_factory, make_small_run):
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    make_small_run(path, chunks=CHUNKS, length=LENGTH)
    return path


@pytest.fixture(scope="module")
def whole(bag):
    return read_bag(bag)


def assert_part(found, whole, part):
    for name in ("steps", "time", "position", "speed", "step_period", "revision", "forces", "stresses"):
        assert getattr(found, name).tobytes() == getattr(whole, name)[part].tobytes(), name


@given(first=st.integers(0, STEPS - 1), count=st.integers(1, STEPS))
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.slow
def test_any_steps(bag, whole, first, count):
    found = read_bag(bag, steps=(first, first + count))
    assert_part(found, whole, slice(first, first + count))
    last = min(first + count, STEPS) - 1
    assert [state.revision for state in found.states] == [*range(whole.revision[first], whole.revision[last] + 1)]


@given(start=st.floats(0, 0.03), length=st.floats(1e-4, 0.04))
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.slow
def test_any_time(bag, whole, start, length):
    held = (whole.time >= start) & (whole.time < start + length)
    assert_part(read_bag(bag, start=start, stop=start + length), whole, held)


def test_only_what_is_needed_is_read(bag, whole, monkeypatch):
    asked = []
    real = McapReader.chunks_at

    def chunks_at(self, places):
        for place in places:
            asked.append(place)
            yield from real(self, [place])

    monkeypatch.setattr(McapReader, "chunks_at", chunks_at)
    found = [*blocks(bag, steps=(600, 640))]
    assert [block.first_step for block in found] == [600, 625]
    assert len(asked) <= 6 + 5  # bisection, then the blocks with one before and one behind


def test_some_nodes_in_any_order(bag, whole):
    found = read_bag(bag, nodes=("C1", "A1"))
    assert found.nodes == ("C1", "A1")
    assert found.stresses.tobytes() == whole.stresses[:, [2, 0]].tobytes()
    assert read_bag(bag, nodes=()).stresses.shape == (STEPS, 0, 6)
    with pytest.raises(InputError, match="has no stress node B7: give one of a1, b1, c1"):
        read_bag(bag, nodes=["B7"])


def test_what_is_not_there(bag):
    with pytest.raises(RecordingError, match="holds no samples from 7 s to 8 s"):
        read_bag(bag, start=7, stop=8)
    with pytest.raises(RecordingError, match=r"holds no samples .* in steps from 5000 to 5009"):
        read_bag(bag, steps=(5000, 5010))
    with pytest.raises(RecordingError, match="holds no samples"):  # between two of them
        read_bag(bag, start=1.01 * 36e-6, stop=1.02 * 36e-6)
    with pytest.raises(InputError, match="give a start before stop"):
        read_bag(bag, start=2, stop=1)
    with pytest.raises(InputError, match="give a start before stop"):
        read_bag(bag, start=float("nan"))
    with pytest.raises(InputError, match="give a first_step from 0 on"):
        read_bag(bag, steps=(5, 5))
    with pytest.raises(InputError, match="give a first_step from 0 on"):
        read_bag(bag, steps=(-1, None))


def test_parts_of_a_damaged_bag(bag, whole, tmp_path):
    content = bytearray(bag.read_bytes())
    place = Bag(bag).reader._places(("ContactForces",))[21][1]
    content[place + 300] ^= 1
    path = tmp_path / "run.mcap"
    path.write_bytes(content)
    assert_part(read_bag(path, steps=(0, 450)), whole, slice(0, 450))
    with pytest.raises(RecordingError, match="not a complete bag"):
        read_bag(path, steps=(450, 600))
    losses = []
    found = read_bag(path, steps=(450, 600), lost=losses.append)
    assert_part(found, whole, np.r_[450:525, 550:600])
    assert [loss for loss in losses if isinstance(loss, Gap)] == [Gap(525, 25, pytest.approx(25 * 36e-6))]
    path.write_bytes(content[:-1])  # without index it is gone through from the beginning
    assert_part(read_bag(path, steps=(450, 600), lost=losses.append), whole, np.r_[450:525, 550:600])


def test_parts_across_files(tmp_path, run_info, run_blocks):
    with BagWriter(tmp_path / "run", run_info, start_ns=0) as writer:
        for block in run_blocks:
            writer.write(block)
            if block is not run_blocks[-1]:
                writer.split()
    found = read_bag(tmp_path / "run", steps=(1380, 1400))
    assert found.steps.tolist() == [*range(1380, 1400)]
    assert found.forces.tobytes() == np.concatenate([block.forces for block in run_blocks])[1380:1400].tobytes()


@given(st.lists(st.one_of(st.none(), st.integers(1, 3)), min_size=1, max_size=60), st.integers(0, 200))
def test_the_chunk_to_begin_with_is_not_after_the_window(lengths, target):
    """Chunks of some samples or of none: the one found, and those before it, hold nothing that is missed."""
    begins, step = [], 0
    for length in lengths:
        begins.append(None if length is None else (step, float(step)))
        step += length or 0
    found = first_chunk(len(lengths), RunWindow(first_step=target), lambda number: begins[number])
    later = [number for number in range(found) if begins[number] is not None]
    following = begins[found]
    if following is not None and found > 0:
        assert following[0] < target
    assert all(begins[number][0] < target for number in later)
    behind = [number for number in range(found + 1, len(lengths)) if begins[number] is not None]
    assert not behind or begins[behind[0]][0] >= target or len(lengths) == 1
