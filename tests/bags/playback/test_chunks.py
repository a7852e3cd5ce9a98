from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.bags.messages import chunk_messages
from wheelset_track_sim.bags.playback.recorded_bag import Played
from wheelset_track_sim.bags.playback.selection import LONGEST, chunked, leading_topic, span_ns
from wheelset_track_sim.bags.topics import Topic, topic_of_node

MS = 10**6


def marked(*items, leading="forces"):
    return [(item.topic, item.begins) for item in chunked([Played(time, topic, b"") for time, topic in items], leading)]


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
            yield Played(number * 50 * MS, "a1", b"")

    next(chunked(messages(), "forces"))
    assert len(read) <= LONGEST / (50 * MS) + 2


def test_forces_lead_then_stresses_then_the_summary():
    kinds = {"s": "LoadSummary", "a": "AxleStress", "f": "ContactForces", "g": "ContactForces"}
    topics = {name: topic_of_node("", name, kind) for name, kind in kinds.items()}
    topics["d"] = Topic("/d", "diagnostic_msgs/msg/DiagnosticArray", "", b"", {})
    assert leading_topic(topics) == "f"
    assert leading_topic({name: topics[name] for name in "sad"}) == "a"
    assert leading_topic({"d": topics["d"]}) is None


def test_span_is_from_the_first_sample_to_behind_the_last(make_block):
    block = make_block(0, 1389)
    spans = {span_ns(message.kind, message.cdr) for message in chunk_messages(block, 0)}
    assert spans == {round(1389 * block.step_period * 1e9)}
