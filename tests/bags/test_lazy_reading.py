"""A bag is read as its blocks are asked for: memory does not grow with its length."""

import pytest
from mcap.reader import make_reader

from wheelset_track_sim.bags import BagWriter, blocks
from wheelset_track_sim.errors import RecordingError


def test_the_first_block_needs_no_more_than_the_beginning(make_block, run_info, tmp_path):
    path = tmp_path / "run.mcap"
    with BagWriter(path, run_info, start_ns=0) as writer:
        time = 0.0
        for number in range(10):
            block = make_block(1389 * number, 1389, time=time)
            writer.write(block)
            time += len(block) * block.step_period
    with path.open("rb") as stream:
        last = make_reader(stream).get_summary().chunk_indexes[-1]
    content = bytearray(path.read_bytes())
    content[last.chunk_start_offset + last.chunk_length // 2] ^= 0xFF
    path.write_bytes(content)
    reading = blocks(path)
    assert [next(reading).first_step for _ in range(5)] == [0, 1389, 2778, 4167, 5556]
    with pytest.raises(RecordingError, match="is not a complete bag"):
        list(reading)
