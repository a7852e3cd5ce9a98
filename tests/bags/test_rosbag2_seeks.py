"""The reader of rosbag2 finds every time in a bag of several files: its rule, tried at every time that matters."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest
from mcap.reader import make_reader

from support.blocks import block_of_numbers, state_of_numbers
from wheelset_track_sim.bags import BagWriter, RecordSettings, RunInfo, read_bag
from wheelset_track_sim.bags.bag_reader import BagReader
from wheelset_track_sim.bags.messages import state_message
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag

START_NS = 1_700_000_000_123_456_789


class Span(NamedTuple):
    first_ns: int
    last_ns: int


def spans_of(bag: Path) -> list[Span]:
    """First and last time of each file, as its statistics have them: what rosbag2 asks of the storage."""
    found = []
    for file in BagReader(bag).files:
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        found.append(Span(summary.statistics.message_start_time, summary.statistics.message_end_time))
    return found


def sought(spans: list[Span], time_ns: int, current: int = 0) -> int:
    """File in which ``SequentialReader::seek`` of rosbag2 0.26 ends; it calls itself as long as it changes files."""
    visited = []
    while True:
        assert current not in visited, f"{time_ns} ns is sought for ever in files {visited}"
        first_ns, last_ns = spans[current]
        if time_ns < first_ns and current > 0:
            step = -1
        elif time_ns > last_ns and current < len(spans) - 1:
            step = 1
        else:
            return current
        visited.append(current)
        current += step


def test_the_rule_shows_the_fault_where_there_is_a_gap() -> None:
    spans = [Span(0, 10), Span(12, 20)]
    assert [sought(spans, time) for time in (0, 10, 12, 20, 25)] == [0, 0, 1, 1, 1]
    with pytest.raises(AssertionError, match="for ever"):
        sought(spans, 11)


def assert_sought(bag: Path) -> None:
    """Each time at and around the ends of the files is found from each file, and no two files share a time."""
    spans = spans_of(bag)
    assert all(before.last_ns + 1 == after.first_ns for before, after in pairwise(spans))
    edges = {edge + near for span in spans for edge in span for near in (-1, 0, 1)}
    for time in edges | {spans[0].first_ns + k * 10**8 for k in range(40)}:
        for current in range(len(spans)):
            sought(spans, time, current)


def test_a_gap_in_the_samples_is_none_for_the_reader(tmp_path: Path, run_info: RunInfo) -> None:
    early, late = block_of_numbers(0, 100), block_of_numbers(50_000, 100, time=2.0, revision=1)
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS) as writer:
        writer.write_state(state_of_numbers(early))
        writer.write(early)
        writer.gap("the disk is too slow")
        writer.write_state(state_of_numbers(late))
        writer.write(late)
    assert_sought(tmp_path / "run")
    [gap] = overview(tmp_path / "run").gaps
    assert (gap.first_step, gap.steps) == (100, 49_900)


def test_states_keep_their_stamps_and_files_their_length(tmp_path: Path, run_info: RunInfo) -> None:
    """Only the time of logging moves; a file is as long as it was asked to be, counted from its first chunk."""
    blocks = [block_of_numbers(100 * n, 100, time=0.4 * n) for n in range(12)]
    settings = RecordSettings(max_duration=1.2)
    state = state_message(state_of_numbers(blocks[0]), START_NS)
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS, settings=settings, state=state) as writer:
        for block in blocks:
            writer.write(block)
    assert len(spans_of(tmp_path / "run")) == 4
    assert_sought(tmp_path / "run")
    assert [state.first_step for state in read_bag(tmp_path / "run").states] == [0, 300, 600, 900]
    found = overview(tmp_path / "run")
    assert found.complete, found.losses
    with RecordedBag(tmp_path / "run") as bag:
        times = [message.time_ns for message in bag.messages(0, 2**62, {*bag.topics})]
    assert times == sorted(times)
    for file in BagReader(tmp_path / "run").files[1:]:
        with file.open("rb") as stream:
            _, channel, message = next(iter(make_reader(stream).iter_messages()))
        assert channel.topic.endswith("/state")
        assert message.publish_time - message.log_time == pytest.approx(4e8, abs=1)
