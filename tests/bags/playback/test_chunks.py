from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.bags.definitions import full_name
from wheelset_track_sim.bags.messages import chunk_messages
from wheelset_track_sim.bags.playback.chunks import LONGEST, chunked, leading_topic, span_ns
from wheelset_track_sim.bags.playback.recorded_bag import Recorded

MS = 10**6


def marked(*items, leading="forces"):
    return [
        (item.message.topic, item.begins)
        for item in chunked([Recorded(time, topic, b"") for time, topic in items], leading)
    ]


def test_a_chunk_begins_with_the_first_message_of_its_time():
    found = marked(
        (0, "state"), (0, "forces"), (0, "a1"), (0, "summary"),
        (30, "impacts"),
        (50, "state"), (50, "forces"), (50, "a1"),
        (100, "forces"),
    )  # fmt: skip
    assert found == [
        ("state", True), ("forces", False), ("a1", False), ("summary", False),
        ("impacts", False),
        ("state", True), ("forces", False), ("a1", False),
        ("forces", True),
    ]  # fmt: skip


def test_messages_recorded_one_after_the_other_belong_to_the_forces_before():
    found = marked((0, "state"), (3, "forces"), (4, "a1"), (5, "summary"), (53, "forces"), (54, "a1"))
    assert [begins for _, begins in found] == [False, True, False, False, True, False]


def test_without_a_leading_topic_each_message_is_a_chunk():
    assert marked((0, "x"), (0, "y"), leading=None) == [("x", True), ("y", True)]


@given(st.lists(st.tuples(st.integers(0, 10**10), st.sampled_from(["forces", "a1", "state"])), max_size=40).map(sorted))
def test_nothing_is_lost_moved_or_added(items):
    assert [topic for topic, _ in marked(*items)] == [topic for _, topic in items]
    begun = {time for time, topic in items if topic == "forces"}
    assert sum(begins for _, begins in marked(*items)) == len(begun)


def test_little_is_read_ahead():
    read = []

    def messages():
        for number in range(1000):
            read.append(number)
            yield Recorded(number * 50 * MS, "a1", b"")

    next(chunked(messages(), "forces"))
    assert len(read) <= LONGEST / (50 * MS) + 2


def test_forces_lead_then_stresses_then_the_summary():
    kinds = {"/s": full_name("LoadSummary"), "/a": full_name("AxleStress"), "/d": "diagnostic_msgs/msg/DiagnosticArray"}
    assert leading_topic(kinds | {"/f": full_name("ContactForces"), "/g": full_name("ContactForces")}) == "/f"
    assert leading_topic(kinds) == "/a"
    assert leading_topic({"/d": kinds["/d"]}) is None


def test_span_is_from_the_first_sample_to_behind_the_last(make_block):
    block = make_block(0, 1389)
    spans = {span_ns(full_name(message.kind), message.cdr) for message in chunk_messages(block, 0)}
    assert spans == {round(1389 * block.step_period * 1e9)}
