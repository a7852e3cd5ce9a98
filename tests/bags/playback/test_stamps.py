from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.bags.definitions import deserialise, serialise
from wheelset_track_sim.bags.messages import chunk_messages, state_message
from wheelset_track_sim.bags.playback.stamps import EARLIEST, LATEST, Restamping, stamp_of, with_stamp
from wheelset_track_sim.samples.block import SampleBlock

stamps = st.integers(0, LATEST)


BLOCK = SampleBlock(0, 0.0, 36e-6, 27.7, 0.0, 0, np.arange(6.0).reshape(3, 2), np.ones((3, 1, 6)), ("A1",))


def cdr_at(stamp_ns):
    return chunk_messages(BLOCK, stamp_ns)[0].cdr


@given(before=stamps, after=stamps)
def test_only_the_stamp_changes(before, after):
    for message in chunk_messages(BLOCK, before):
        assert stamp_of(message.cdr) == before
        stamp = dict(zip(("sec", "nanosec"), divmod(after, 10**9), strict=True))
        fields = {**message.fields, "header": {**message.fields["header"], "stamp": stamp}}
        assert with_stamp(message.cdr, after) == serialise(message.kind, fields)
        assert with_stamp(with_stamp(message.cdr, after), before) == message.cdr


def test_header_comes_first_in_every_message_of_a_run(make_state):
    for message in [*chunk_messages(BLOCK, 10**18 + 1), state_message(make_state(BLOCK), 10**18 + 1)]:
        found = deserialise(message.kind, with_stamp(message.cdr, 5 * 10**9 + 7))
        assert (found.header.stamp.sec, found.header.stamp.nanosec, found.header.frame_id) == (5, 7, "track")


@given(stamp=stamps)
def test_either_end_may_come_first(stamp):
    seconds, nanoseconds = divmod(stamp, 10**9)
    big = bytes(4) + seconds.to_bytes(4, "big") + nanoseconds.to_bytes(4, "big") + b"rest"
    assert stamp_of(big) == stamp
    assert with_stamp(big, 3 * 10**9 + 1) == bytes([0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 1]) + b"rest"


@pytest.mark.parametrize("stamp", [EARLIEST - 1, LATEST + 1, 10**30])
def test_stamp_that_does_not_fit_is_cut_off(stamp):
    assert stamp_of(with_stamp(cdr_at(0), stamp)) in (EARLIEST, LATEST)


def test_what_is_too_short_is_no_stamped_message():
    with pytest.raises(ValueError, match="hold no header"):
        stamp_of(b"\0\1\0\0abc")


def test_chunks_meet_as_they_did():
    now = 1_800_000_000 * 10**9
    restamping = Restamping()
    recorded = [1_700_000_000_000_000_123 + step for step in (0, 0, 50_000_001, 75_000_000, 100_000_007)]
    given = [stamp_of(restamping.apply("", cdr_at(stamp), now + 999 * number)) for number, stamp in enumerate(recorded)]
    assert given[0] == now
    assert [after - before for before, after in pairwise(given)] == [b - a for a, b in pairwise(recorded)]


@given(parts=st.lists(st.lists(st.integers(0, 10**12), min_size=1, max_size=5).map(sorted), min_size=1, max_size=4))
def test_stamps_never_go_back_whatever_part_follows(parts):
    restamping = Restamping()
    played, found = 10**18, []
    for part in parts:
        restamping.restart()
        for stamp in part:
            found.append(stamp_of(restamping.apply("", cdr_at(stamp), played)))
            assert found[-1] >= played - (stamp - part[0]) or found == sorted(found)
        played += 1
    assert found == sorted(found)


def test_families_have_their_own_shift():
    restamping = Restamping()
    assert stamp_of(restamping.apply("", cdr_at(100), 10**18)) == 10**18
    assert stamp_of(restamping.apply("/diagnostics", cdr_at(777), 10**18 + 5)) == 10**18 + 5
    assert stamp_of(restamping.apply("", cdr_at(150), 10**18 + 60)) == 10**18 + 50
