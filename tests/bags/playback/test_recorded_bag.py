"""Messages as they were recorded: own bags and foreign ones, whole and damaged, from any time on."""

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from wheelset_track_sim.bags import BagWriter
from wheelset_track_sim.bags.definitions import full_name, schema
from wheelset_track_sim.bags.messages import chunk_messages, impact_message
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.playback.selection import Selection
from wheelset_track_sim.errors import RecordingError
from wheelset_track_sim.samples.impacts import Impact

START = 1_700_000_000_123_456_789
NODE = "/wheelset_track_sim"
CHUNKS = 40
SAMPLES = 700
IMPACT = Impact(
    step=900, time=0.0324, speed=27.7, position=0.9, revision=0, wheel=0, angle=0.1, peak_force=3e5,
    static_force=98100.0, duration=1e-3, contact_loss=0.0, threshold=2e5,
)  # fmt: skip


@pytest.fixture
def run(make_block, make_state):
    blocks, time = [], 0.0
    for number in range(CHUNKS):
        blocks.append(make_block(SAMPLES * number, SAMPLES, time=time))
        time += SAMPLES * blocks[-1].step_period
    return blocks


@pytest.fixture(params=["run.mcap", "run"], ids=["file", "folder"])
def path(request, tmp_path, run, run_info, make_state):
    """A bag; as a folder it is of two files."""
    path = tmp_path / request.param
    with BagWriter(path, run_info, start_ns=START) as writer:
        for number, block in enumerate(run):
            if number % 20 == 0:
                writer.write_state(make_state(block))
            if number == 25 and not path.suffix:
                writer.split()
            writer.write(block)
            if number == 3:
                writer.write_messages([impact_message(IMPACT, START)])  # of two chunks before
    return path


def files_of(path):
    return [path] if path.is_file() else sorted(path.glob("*.mcap"))


def as_libraries_read(path):
    """What MCAP's own reader yields."""
    for file in files_of(path):
        with file.open("rb") as stream:
            for _, channel, message in make_reader(stream).iter_messages():
                yield message.log_time, channel.topic, message.data


def everything(bag, begin=0, end=2**62):
    return [item[:3] for item in bag.messages(begin, end, {*bag.topics})]


def test_every_message_of_every_topic_bit_by_bit_in_the_order_of_time(path):
    with RecordedBag(path) as bag:
        found = everything(bag)
        assert found == [*as_libraries_read(path)]
        assert len(found) >= 5 * CHUNKS + 3
        assert bag.damages == []
        assert [time for time, _, _ in found] == sorted(time for time, _, _ in found)
        assert bag.start_ns == START
        assert bag.last_ns == found[-1][0]


def test_topics_say_what_a_publisher_must_know(path):
    with RecordedBag(path) as bag:
        kinds = {name.removeprefix(f"{NODE}/"): topic.kind for name, topic in bag.topics.items()}
        assert kinds == {
            "state": "SimulationState",
            "contact_forces": "ContactForces",
            "axle_stress/a1": "AxleStress",
            "axle_stress/b1": "AxleStress",
            "axle_stress/c1": "AxleStress",
            "summary": "LoadSummary",
            "impacts": "WheelImpact",
        }
        for topic in bag.topics.values():
            assert (topic.reliable, topic.stamped, topic.outdated) == (True, True, False)
            assert topic.prefix == NODE
            assert (topic.latched, topic.depth) == ((True, 1) if topic.name.endswith("/state") else (False, 50))


@pytest.mark.parametrize("share", [0.0, 0.1, 0.33, 0.5, 0.61, 0.99])
def test_from_any_time_on_and_to_any_time(path, share):
    everywhere = [*as_libraries_read(path)]
    with RecordedBag(path) as bag:
        at = bag.start_ns + round(share * (bag.last_ns - bag.start_ns))
        assert everything(bag, begin=at) == [item for item in everywhere if item[0] >= at]
        assert everything(bag, end=at) == [item for item in everywhere if item[0] < at]
        wanted = f"{NODE}/summary"
        some = [item[:3] for item in bag.messages(at, 2**62, {wanted})]
        assert some == [item for item in everywhere if item[0] >= at and item[1] == wanted]


def test_what_late_subscribers_are_told(path, run):
    with RecordedBag(path) as bag:
        everywhere = everything(bag)
        selection = Selection(bag, bag.topics)
        states = [item for item in everywhere if item[1] == f"{NODE}/state"]
        for at in (bag.start_ns, bag.start_ns + 1, states[-1][0], states[-1][0] + 1, bag.last_ns + 1):
            before = [item for item in states if item[0] < at]
            assert [item[:3] for item in selection.held_at(at)] == before[-1:]


def test_the_end_is_behind_the_last_chunk(path, run):
    with RecordedBag(path) as bag:
        selection = Selection(bag, bag.topics)
        assert selection.leading == f"{NODE}/contact_forces"
        assert selection.end_ns == bag.last_ns + round(SAMPLES * run[-1].step_period * 1e9)
        begun = [item.time_ns for item in selection.played(0, 2**62) if item.begins]
        assert begun == [START + round(block.time * 1e9) for block in run]


def test_only_what_is_asked_for_is_read(path):
    with RecordedBag(path) as bag:
        reading = bag.messages(bag.start_ns, 2**62, {*bag.topics})
        next(reading)
        assert sum(source._stream.tell() for source, _ in bag._files) < sum(
            file.stat().st_size for file in files_of(path)
        )


def flip(file, place):
    content = bytearray(file.read_bytes())
    content[place] ^= 0x10
    file.write_bytes(content)


def test_a_damaged_chunk_is_left_out_and_named_and_all_else_is_played(path):
    whole = [*as_libraries_read(path)]
    file = files_of(path)[-1]
    with file.open("rb") as stream:
        index = make_reader(stream).get_summary().chunk_indexes[2]
    flip(file, index.chunk_start_offset + index.chunk_length // 2)
    with RecordedBag(path) as bag:
        found = everything(bag)
        assert found == everything(bag)  # also the second time
        [damage] = bag.damages
        assert damage.startswith(file.name)
    lost = [item for item in whole if item not in found]
    assert found == [item for item in whole if item not in lost]
    assert lost
    assert all(index.message_start_time <= time <= index.message_end_time for time, _, _ in lost)


@pytest.mark.parametrize("share", [0.3, 0.7, 0.999])
def test_a_file_that_was_not_closed_is_played_to_its_last_whole_chunk(path, share):
    whole = [*as_libraries_read(path)]
    file = files_of(path)[-1]
    content = file.read_bytes()
    with file.open("rb") as stream:
        ends = [
            index.chunk_start_offset + index.chunk_length for index in make_reader(stream).get_summary().chunk_indexes
        ]
    cut = round(share * ends[-1])
    file.write_bytes(content[:cut])
    with RecordedBag(path) as bag:
        found = everything(bag)
        assert bag.damages
        assert all(damage.startswith(file.name) for damage in bag.damages)
        assert found == [item for item in whole if item in found]
        assert 0 < len(found) < len(whole)
        assert bag.topics[f"{NODE}/contact_forces"].type == full_name("ContactForces")


def test_nothing_to_be_played_is_refused_in_one_line(tmp_path):
    empty = tmp_path / "empty.mcap"
    empty.write_bytes(b"")
    for path, told in [
        (tmp_path / "none", "does not exist"),
        (tmp_path, "holds no message that can be read"),
        (empty, "holds no message that can be read"),
    ]:
        with pytest.raises(RecordingError, match=told) as refusal:
            RecordedBag(path)
        assert "\n" not in str(refusal.value)


def foreign(path, topics, messages):
    """A bag as ``ros2 bag record`` writes it: log times are those of arrival, other topics among ours."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=20_000, compression=CompressionType.NONE)
        writer.start("ros2", "rosbag2")
        channels = {}
        for name, (kind, text, profiles) in topics.items():
            number = writer.register_schema(kind, "ros2msg", text.encode())
            channels[name] = writer.register_channel(name, "cdr", number, {"offered_qos_profiles": profiles})
        for time, name, data in messages:
            writer.add_message(channels[name], time, data, time)
        writer.finish()


JAZZY = (
    "- history: unknown\n  depth: 0\n  reliability: {}\n  durability: {}\n  avoid_ros_namespace_conventions: false\n"
)
HUMBLE = "- history: 3\n  depth: 0\n  reliability: 2\n  durability: 1\n"


def test_a_bag_of_ros2_bag_record(tmp_path, run):
    store = get_typestore(Stores.ROS2_JAZZY)
    diagnostics = "diagnostic_msgs/msg/DiagnosticArray"
    text, _ = store.generate_msgdef(diagnostics, ros_version=2)
    topics = {
        f"{NODE}/contact_forces": (full_name("ContactForces"), schema("ContactForces"), ""),
        f"{NODE}/state": (
            full_name("SimulationState"),
            schema("SimulationState"),
            JAZZY.format("reliable", "transient_local"),
        ),
        "/diagnostics": (diagnostics, text, JAZZY.format("best_effort", "volatile")),
        "/odd": ("std_msgs/msg/Float64", "float64 data\n", HUMBLE),
    }
    messages = []
    for block in run:
        [forces, *_] = chunk_messages(block, START)
        messages.append((forces.stamp_ns + 53_000_000, f"{NODE}/contact_forces", forces.cdr))
        messages.append((forces.stamp_ns + 53_000_100, "/odd", np.float64(3).tobytes()))
    path = tmp_path / "foreign.mcap"
    foreign(path, topics, messages)
    with RecordedBag(path) as bag:
        assert everything(bag) == messages
        found = bag.topics
        assert {name: (item.reliable, item.latched, item.depth, item.stamped) for name, item in found.items()} == {
            f"{NODE}/contact_forces": (True, False, 50, True),
            f"{NODE}/state": (True, True, 1, True),
            "/diagnostics": (False, False, 50, True),
            "/odd": (False, True, 1, False),
        }
        assert [item.prefix for item in found.values()] == [NODE, NODE, None, None]
        selection = Selection(bag, found)
        assert sum(item.begins for item in selection.played(0, 2**62)) == len(run)


def test_a_type_that_has_been_changed_since_is_not_taken_for_todays(tmp_path, run):
    older = schema("ContactForces").replace("uint32 decimation", "uint16 decimation")
    topics = {
        "/a/contact_forces": (full_name("ContactForces"), older, ""),
        "/b/contact_forces": (full_name("ContactForces"), schema("ContactForces"), ""),
    }
    message = chunk_messages(run[0], START)[0]
    path = tmp_path / "older.mcap"
    foreign(path, topics, [(START, name, message.cdr) for name in topics])
    with RecordedBag(path) as bag:
        assert [topic.outdated for topic in bag.topics.values()] == [True, False]


def test_a_bag_without_chunks_rests_before_it_begins_again(tmp_path):
    path = tmp_path / "plain.mcap"
    foreign(path, {"/x": ("std_msgs/msg/Float64", "float64 data\n", "")}, [(START, "/x", bytes(12))])
    with RecordedBag(path) as bag:
        selection = Selection(bag, bag.topics)
        assert selection.leading is None
        assert selection.end_ns > START + 10**7


def test_an_impact_is_played_in_the_chunk_in_which_it_was(path):
    with RecordedBag(path) as bag:
        topics = [item.topic for item in Selection(bag, bag.topics).played(0, 2**62)]
        place = topics.index(f"{NODE}/impacts")
        assert topics[:place].count(f"{NODE}/contact_forces") == 2
        [found] = bag.messages(0, 2**62, {f"{NODE}/impacts"})
        assert found.cdr == impact_message(IMPACT, START).cdr
