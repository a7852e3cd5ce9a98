"""What other programs find in a bag: rosbags, the MCAP library and mcap-ros2-support, by their own rules."""

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from wheelset_track_sim.bags import BagWriter, RecordSettings
from wheelset_track_sim.bags.snapshots import writer_of
from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.wheelset.reduced import COMPONENTS

START_NS = 1_700_000_000_123_456_789
TYPES = {
    "/wheelset_track_sim/contact_forces": "wheelset_track_msgs/msg/ContactForces",
    "/wheelset_track_sim/axle_stress/a1": "wheelset_track_msgs/msg/AxleStress",
    "/wheelset_track_sim/axle_stress/b1": "wheelset_track_msgs/msg/AxleStress",
    "/wheelset_track_sim/axle_stress/c1": "wheelset_track_msgs/msg/AxleStress",
    "/wheelset_track_sim/summary": "wheelset_track_msgs/msg/LoadSummary",
    "/wheelset_track_sim/state": "wheelset_track_msgs/msg/SimulationState",
}


@pytest.fixture(params=["run.mcap", "run"], ids=["file", "folder"])
def bag(request, tmp_path, run_info, run_blocks, make_state):
    path = tmp_path / request.param
    with BagWriter(path, run_info, start_ns=START_NS) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks:
            writer.write(block, real_time_factor=31.5, lag=0.25)
    return path


def mcap_file(bag):
    return bag if bag.is_file() else bag / "run_0.mcap"


def stamp(block):
    return START_NS + round(block.time * 1e9)


def test_rosbags(bag, run_blocks):
    with AnyReader([bag]) as reader:
        assert {connection.topic: connection.msgtype for connection in reader.connections} == TYPES
        found = {topic: [] for topic in TYPES}
        for connection, log_time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == log_time
            assert message.header.frame_id == "track"
            found[connection.topic].append((log_time, message))
    assert [len(messages) for messages in found.values()] == [3, 3, 3, 3, 3, 1]
    for index, block in enumerate(run_blocks):
        log_time, forces = found["/wheelset_track_sim/contact_forces"][index]
        assert log_time == stamp(block)
        assert (forces.first_step, forces.time, forces.revision) == (block.first_step, block.time, block.revision)
        np.testing.assert_array_equal(forces.wheel_2, block.forces[:, 1])
        _, stress = found["/wheelset_track_sim/axle_stress/b1"][index]
        assert stress.node == "B1"
        np.testing.assert_array_equal(stress.xz, block.stresses[:, 1, 4])
        np.testing.assert_array_equal(stress.max_principal, maximum_principal(block.stresses[:, 1]))


def test_mcap_ros2_support(bag, run_blocks):
    with mcap_file(bag).open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = [(channel.topic, decoded) for _, channel, _, decoded in reader.iter_decoded_messages()]
    assert len(found) == 16
    summaries = [decoded for topic, decoded in found if topic.endswith("/summary")]
    for message, block in zip(summaries, run_blocks, strict=True):
        expected = summarise(block)
        assert message.samples == len(block)
        assert message.wheel_1_max_force == expected.wheels[0].max_force
        assert message.wheel_2_contact_loss == expected.wheels[1].contact_loss
        assert list(message.nodes) == ["A1", "B1", "C1"]
        for name in ("max", "min", "mean", "rms"):
            told = list(getattr(message, f"max_principal_{name}"))
            assert told == [getattr(node, f"{name}_principal") for node in expected.nodes]
        components = block.stresses.reshape(len(block), -1)
        np.testing.assert_array_equal(message.stress_max, components.max(axis=0))
        np.testing.assert_array_equal(message.stress_min, components.min(axis=0))
        np.testing.assert_allclose(message.stress_mean, components.mean(axis=0), rtol=1e-9)
        np.testing.assert_allclose(message.stress_rms, np.sqrt((components**2).mean(axis=0)), rtol=1e-12)
        assert (message.real_time_factor, message.lag) == (31.5, 0.25)
    (state,) = (decoded for topic, decoded in found if topic.endswith("/state"))
    assert "Ångström" in state.scenario
    assert [(item.wheel, item.h, item.y) for item in state.damage] == [(1, 0.002, -0.001)]


def test_the_file_says_how_to_read_it(bag, run_info):
    with mcap_file(bag).open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert {channel.topic for channel in summary.channels.values()} == set(TYPES)
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            assert (channel.message_encoding, schema.encoding, schema.name) == ("cdr", "ros2msg", TYPES[channel.topic])
            assert "MSG: std_msgs/Header" in schema.data.decode()
            assert "MSG: builtin_interfaces/Time" in schema.data.decode()
            assert "# " in schema.data.decode().splitlines()[0]  # comments say the units
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        assert all(chunk.compression == "zstd" for chunk in summary.chunk_indexes)
        (record,) = reader.iter_metadata()
    assert record.name == "wheelset_track_sim"
    assert record.metadata["scenario"] == run_info.scenario
    assert record.metadata["digest"] == run_info.digest


def test_latched_state_reaches_late_subscribers(bag):
    with mcap_file(bag).open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
    durability = {}
    for channel in channels:
        (profile,) = yaml.safe_load(channel.metadata["offered_qos_profiles"])
        assert profile["reliability"] == "reliable"
        durability[channel.topic.rpartition("/")[2]] = profile["durability"]
    assert durability.pop("state") == "transient_local"
    assert set(durability.values()) == {"volatile"}


def test_folder_has_the_metadata_of_ros2_bag(tmp_path, run_info, run_blocks):
    path = tmp_path / "run"
    with BagWriter(path, run_info, start_ns=START_NS) as writer:
        early = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
        for block in run_blocks:
            writer.write(block)
    assert early["relative_file_paths"] == ["run_0.mcap"]  # a crash leaves a folder that can be opened
    info = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (info["version"], info["storage_identifier"], info["message_count"]) == (9, "mcap", 15)
    assert info["starting_time"]["nanoseconds_since_epoch"] == START_NS
    assert info["duration"]["nanoseconds"] == stamp(run_blocks[2]) - START_NS
    assert info["files"][0]["message_count"] == 15
    assert {"custom_data", "ros_distro", "compression_mode", "compression_format"} <= info.keys()
    assert sorted(file.name for file in path.iterdir()) == ["metadata.yaml", "run_0.mcap"]


def test_chunks_are_small_in_time(tmp_path, run_info, make_block):
    path = tmp_path / "run.mcap"
    with BagWriter(path, run_info, start_ns=START_NS) as writer:
        for first in range(0, 27780, 1389):
            writer.write(make_block(first, 1389, time=first * 3.6e-5))
        on_disk = path.stat().st_size
    assert on_disk > 0.8 * path.stat().st_size  # what a crash would leave
    with path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    assert len(chunks) >= 5
    assert max(chunk.message_end_time - chunk.message_start_time for chunk in chunks) <= 0.2e9


SETTINGS = {
    "split": RecordSettings(max_duration=1.0),
    "bounded": RecordSettings(max_total_size=10_000_000),
    "snapshot": RecordSettings("snapshot", snapshot_duration=2.0),
}


@pytest.fixture(params=["split", *(pytest.param(name, marks=pytest.mark.slow) for name in ("bounded", "snapshot"))])
def long_bag(request, tmp_path, run_info, make_block, make_state):
    """A bag folder of a run of 4 s, or a snapshot of its end, and the blocks of the run by their first step."""
    blocks = {first: make_block(first, 1389, time=first * 3.6e-5) for first in range(0, 80 * 1389, 1389)}
    with writer_of(tmp_path / "run", run_info, SETTINGS[request.param], start_ns=START_NS) as writer:
        writer.write_state(make_state(blocks[0]))
        for block in blocks.values():
            writer.write(block)
        path = writer.snapshot() if request.param == "snapshot" else writer.path
    return path, blocks


@pytest.mark.slow
def test_split_bounded_and_snapshot_bags_bit_by_bit_in_all_readers(long_bag):
    path, blocks = long_bag
    files = sorted(path.glob("*.mcap"), key=lambda file: int(file.stem.rpartition("_")[2]))
    found = {"rosbags": [], "mcap-ros2-support": []}
    with AnyReader([path]) as reader:
        assert {connection.topic: connection.msgtype for connection in reader.connections} == TYPES
        for connection, _, raw in reader.messages():
            found["rosbags"].append((connection.topic, reader.deserialize(raw, connection.msgtype)))
    for file in files:
        with file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            alone = [(channel.topic, decoded) for _, channel, _, decoded in reader.iter_decoded_messages()]
        (state,) = [message for topic, message in alone if topic.endswith("/state")]
        assert state.first_step == min(message.first_step for topic, message in alone if topic.endswith("/summary"))
        found["mcap-ros2-support"] += alone
    for messages in found.values():
        forces = [message for topic, message in messages if topic.endswith("/contact_forces")]
        firsts = [message.first_step for message in forces]
        assert firsts == [*range(firsts[0], 80 * 1389, 1389)]
        for message in forces:
            assert np.array(message.wheel_1).tobytes() == blocks[message.first_step].forces[:, 0].tobytes()
        for topic, message in messages:
            if topic.endswith("/c1"):
                column = blocks[message.first_step].stresses[:, 2, COMPONENTS.index("yz")]
                assert np.array(message.yz).tobytes() == column.tobytes()
    information = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == len(found["rosbags"]) == len(found["mcap-ros2-support"])
    assert information["relative_file_paths"] == [file.name for file in files]
