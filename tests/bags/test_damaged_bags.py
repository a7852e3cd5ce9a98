"""What can be read of a damaged bag is what was recorded, to the bit; all else is named."""

import dataclasses
import io

import numpy as np
import pytest
from mcap.reader import make_reader

from wheelset_track_sim.bags import Bag, BagWriter, Damage, Gap, State
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.run_info import RunInfo
from wheelset_track_sim.errors import RecordingError
from wheelset_track_sim.report.survey import survey

CHUNKS = 12
LENGTH = 300


@pytest.fixture(scope="module")
def whole(tmp_path_factory, make_small_run):
    """A bag of a few chunks as bytes, and its blocks by step."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    made = make_small_run(path, chunks=CHUNKS, length=LENGTH)
    return path.read_bytes(), made


def chunk_places(content):
    return [index.chunk_start_offset for index in make_reader(io.BytesIO(content)).get_summary().chunk_indexes]


def read_all(path):
    """Blocks and states that can be read, and what was lost."""
    losses = []
    events = [*Bag(path, losses.append).events()]
    return [e for e in events if not isinstance(e, State)], [e for e in events if isinstance(e, State)], losses


def assert_nothing_is_wrong(path, made):
    """Whatever is read is what was written; returns how many blocks there were."""
    blocks, states, info = made
    try:
        found, found_states, losses = read_all(path)
    except RecordingError:
        return 0
    by_step = {block.first_step: block for block in blocks}
    for block in found:
        for field in dataclasses.fields(block):
            one, other = getattr(block, field.name), getattr(by_step[block.first_step], field.name)
            assert one.tobytes() == other.tobytes() if isinstance(one, np.ndarray) else one == other, field.name
    assert all(state in states for state in found_states)
    gaps = sum(loss.steps for loss in losses if isinstance(loss, Gap))
    assert sum(map(len, found)) + gaps == found[-1].first_step + len(found[-1]) - found[0].first_step
    told = Bag(path, losses.append).info
    assert told == info or dataclasses.replace(info, sleeper_spacing=0.0, versions={}, models={}, inputs=()) == (
        dataclasses.replace(told, sleeper_spacing=0.0)
    )
    if len(found) < len(blocks) or told != info:
        assert losses
    return len(found)


@pytest.mark.slow
def test_truncated_at_any_byte(tmp_path, whole):
    content, made = whole
    path = tmp_path / "run.mcap"
    random = np.random.default_rng(1)
    kept = []
    for place in np.sort(random.integers(0, len(content), 200)):
        path.write_bytes(content[:place])
        kept.append(assert_nothing_is_wrong(path, made))
    assert kept == sorted(kept)
    assert set(kept) == set(range(CHUNKS + 1))


@pytest.mark.slow
def test_any_bit_flipped(tmp_path, whole):
    content, made = whole
    path = tmp_path / "run.mcap"
    random = np.random.default_rng(2)
    kept = []
    for place, bit in zip(random.integers(0, len(content), 200), random.integers(0, 8, 200), strict=True):
        path.write_bytes(content[:place] + bytes([content[place] ^ (1 << bit)]) + content[place + 1 :])
        kept.append(assert_nothing_is_wrong(path, made))
    assert set(kept) == {CHUNKS - 1, CHUNKS}


@pytest.mark.slow
def test_a_flip_in_the_first_bytes_loses_no_samples(tmp_path, whole):
    """Magic, header and metadata stand outside of chunks, and the metadata have a checksum of their own."""
    content, made = whole
    path = tmp_path / "run.mcap"
    end = chunk_places(content)[0]
    for place in range(0, end, max(1, end // 150)):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x04]) + content[place + 1 :])
        assert assert_nothing_is_wrong(path, made) == CHUNKS, place


def test_damage_is_told_by_its_bytes_and_steps(tmp_path, whole):
    content, _ = whole
    path = tmp_path / "run.mcap"
    start, following = chunk_places(content)[4:6]
    path.write_bytes(content[: start + 200] + bytes(50) + content[start + 250 :])
    found, _, losses = read_all(path)
    assert len(found) == CHUNKS - 1
    damage, gap = losses
    assert isinstance(damage, Damage)
    assert damage.place == start < damage.end <= following
    assert damage.reason.startswith("a chunk is damaged")
    assert (gap.first_step, gap.steps) == (4 * LENGTH, LENGTH)
    assert gap.seconds == pytest.approx(LENGTH * found[0].step_period)
    assert str(gap).startswith(f"steps {4 * LENGTH} to {5 * LENGTH - 1} are missing (0.0108 s)")
    with pytest.raises(RecordingError, match=r"run.mcap is not a complete bag \(bytes \d+ to \d+: a chunk is damaged"):
        list(Bag(path).events())


def test_a_bag_that_was_not_closed(tmp_path, whole):
    content, (blocks, *_) = whole
    path = tmp_path / "run.mcap"
    last = chunk_places(content)[-1]
    path.write_bytes(content[:last])
    found, _, losses = read_all(path)
    assert len(found) == len(blocks) - 1
    assert losses == [Damage("run.mcap", last, last, "it was not closed")]


def test_missing_files_are_told(tmp_path, run_info, run_blocks, make_state):
    bag = tmp_path / "run"
    with BagWriter(bag, run_info, start_ns=0) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks:
            writer.write(block)
            if block is not run_blocks[-1]:
                writer.split()
    (bag / "run_1.mcap").unlink()
    with pytest.raises(RecordingError, match=r"run_1\.mcap, which metadata.yaml names: it is missing"):
        list(Bag(bag).events())
    found, _, losses = read_all(bag)
    assert [block.first_step for block in found] == [0, 1390]
    assert losses == [Damage("run_1.mcap", 0, 0, "it is missing"), Gap(1389, 1, pytest.approx(36e-6, rel=1e-3))]
    (bag / "metadata.yaml").unlink()
    (bag / "run_0.mcap").write_bytes(b"")
    found, _, losses = read_all(bag)
    assert [block.first_step for block in found] == [1390]
    assert [str(loss) for loss in losses] == ["metadata.yaml: it is missing", "run_0.mcap: it is empty"]


def test_steps_that_come_again_are_left_out(tmp_path, run_info, run_blocks):
    path = tmp_path / "run.mcap"
    with BagWriter(path, run_info, start_ns=0) as writer:
        for block in (run_blocks[1], run_blocks[2], run_blocks[1]):
            writer.write(block)
    found, _, losses = read_all(path)
    assert [block.first_step for block in found] == [1389, 1390]
    assert "steps from 1389 on come again after step 2089" in str(losses[0])


@pytest.mark.parametrize("content", [b"", b"speed: 3\n" * 100, bytes(5000), b"\x89MCAP0\r\n"])
def test_other_files_hold_nothing(tmp_path, content):
    path = tmp_path / "run.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"holds no complete chunk|is neither MCAP") as error:
        read_all(path)
    assert "\n" not in str(error.value)


def test_metadata_know_whether_they_are_what_was_written():
    record = RunInfo("undamaged", "speed: 30\n", "0123", 0.6).to_metadata()
    for name in record:
        with pytest.raises((LookupError, ValueError)):
            RunInfo.from_metadata({**record, name: record[name].replace(record[name][-1], "?")})


def test_a_gap_of_hours_ends_a_run(tmp_path, run_info, run_blocks):
    """Every reader passes the steps of a gap one way or the other."""
    path = tmp_path / "run.mcap"
    later = dataclasses.replace(run_blocks[1], first_step=10**12, time=3.6e7)
    with BagWriter(path, run_info, start_ns=0) as writer:
        writer.write(run_blocks[0])
        writer.write(later)
    found, _, losses = read_all(path)
    assert [block.first_step for block in found] == [0]
    assert "a gap of more than 100000000 steps ends the run" in str(losses[0])
    assert not overview(path).complete
    assert survey(path).steps == 1389
