"""Recovered bags hold what the damaged ones held, to the byte, and every tool opens them."""

import os

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from wheelset_track_sim.bags import Bag, BagWriter, Gap
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import InputError, RecordingError

CHUNKS = 8
LENGTH = 60


@pytest.fixture(scope="module")
def whole(tmp_path_factory, make_small_run):
    """A bag as bytes, and every message of it by topic and time."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    make_small_run(path, chunks=CHUNKS, length=LENGTH)
    return path.read_bytes(), messages(path)


def messages(path):
    """Every message by topic and time, as the MCAP library reads them, checksums checked."""
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    found = {}
    for file in files:
        with file.open("rb") as stream:
            for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
                key = channel.topic, message.log_time
                found[key] = (message.data, message.publish_time, message.sequence, schema.data, channel.metadata)
    return found


def assert_whole(bag, original):
    """All that a recovered bag holds was in the original, by mcap and by rosbags; how many messages it has."""
    found = messages(bag)
    for key, message in found.items():
        assert message == original[key], key
    with Reader(bag) as reader:  # goes by metadata.yaml
        assert reader.message_count == sum(1 for _ in reader.messages()) == len(found)


def assert_decodes(bag):
    """Every message can be decoded by readers that know nothing of this package."""
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
    for file in bag.glob("*.mcap"):
        with file.open("rb") as stream:
            for decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
                assert decoded.decoded_message.first_step >= 0


def recovered(path, original, seen):
    """Recover ``path``, check what is new in the result; how many chunks of samples it had, and what was lost."""
    before, new = path.read_bytes(), path.with_name("new.mcap")
    try:
        found = recover(path, new)
    except RecordingError:
        assert [item.name for item in path.parent.iterdir()] == ["run.mcap"]
        return 0, ()
    assert path.read_bytes() == before
    content = new.read_bytes()
    if content not in seen:
        seen[content] = len(messages(new))
        for key, message in messages(new).items():
            assert message == original[key], key
        with AnyReader([new]) as reader:
            assert reader.message_count == sum(1 for _ in reader.messages()) == seen[content]
    assert found.messages == seen[content]
    assert found.steps + sum(gap.steps for gap in found.gaps) <= CHUNKS * LENGTH
    new.unlink()
    return found.steps // LENGTH, found.losses


@pytest.mark.slow
def test_truncated_at_any_byte(tmp_path, whole):
    content, original = whole
    path = tmp_path / "run.mcap"
    kept, seen = [], {}
    for place in np.sort(np.random.default_rng(3).integers(0, len(content), 200)):
        path.write_bytes(content[:place])
        chunks, losses = recovered(path, original, seen)
        kept.append(chunks)
        assert losses or chunks == 0
    assert kept == sorted(kept)
    assert set(kept) >= set(range(1, CHUNKS))


@pytest.mark.slow
def test_any_bit_flipped(tmp_path, whole):
    content, original = whole
    path = tmp_path / "run.mcap"
    random = np.random.default_rng(4)
    kept, seen = [], {}
    for place, bit in zip(random.integers(0, len(content), 200), random.integers(0, 8, 200), strict=True):
        path.write_bytes(content[:place] + bytes([content[place] ^ (1 << bit)]) + content[place + 1 :])
        chunks, losses = recovered(path, original, seen)
        kept.append(chunks)
        assert losses or chunks == CHUNKS
    assert set(kept) == {CHUNKS - 1, CHUNKS}


def test_several_kinds_of_damage_at_once(tmp_path, whole):
    content, original = whole
    path = tmp_path / "run.mcap"
    third = len(content) // 3
    path.write_bytes(content[:third] + os.urandom(10_000) + content[third + 15_000 : -1])
    found = recover(path)
    assert_whole(found.path, original)
    assert_decodes(found.path)
    assert found.path == tmp_path / "run_recovered"
    assert sorted(item.name for item in found.path.iterdir()) == ["metadata.yaml", "run_recovered_0.mcap"]
    assert CHUNKS - 3 <= found.steps // LENGTH < CHUNKS
    assert found.chunks_lost >= 1
    assert found.bytes_lost > 10_000
    assert any(isinstance(loss, Gap) for loss in found.losses)


def test_an_undamaged_bag_is_copied_whole(tmp_path, whole):
    content, original = whole
    (tmp_path / "run.mcap").write_bytes(content)
    found = recover(tmp_path / "run.mcap", tmp_path / "made" / "new.mcap")
    assert messages(tmp_path / "made" / "new.mcap") == original
    assert (found.chunks, found.chunks_lost, found.losses, found.bytes_lost) == (CHUNKS, 0, (), 0)
    assert Bag(found.path).info == Bag(tmp_path / "run.mcap").info


@pytest.fixture
def folder(tmp_path, run_info, run_blocks, make_state):
    """A bag of three files."""
    path = tmp_path / "run"
    with BagWriter(path, run_info, start_ns=0) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks:
            writer.write(block)
            if block is not run_blocks[-1]:
                writer.split()
    return path


def test_missing_files_and_metadata(folder):
    original = messages(folder)
    (folder / "metadata.yaml").unlink()
    (folder / "run_1.mcap").unlink()
    (folder / "run_2.mcap").write_bytes((folder / "run_2.mcap").read_bytes()[:-50])
    found = recover(folder)
    assert_whole(found.path, original)
    assert_decodes(found.path)
    assert sorted(item.name for item in found.path.iterdir()) == [
        "metadata.yaml",
        "run_recovered_0.mcap",
        "run_recovered_1.mcap",
    ]
    assert str(found.losses[0]) == "metadata.yaml: it is missing"
    assert found.gaps == (Gap(1389, 1, pytest.approx(36e-6, rel=1e-3)),)
    assert (found.first_step, found.steps) == (0, 2089)


def test_a_file_of_a_folder_is_recovered_without_becoming_one_of_its_files(folder):
    before = Bag(folder).files
    found = recover(folder / "run_0.mcap")
    assert found.path == folder / "run_0_recovered"
    assert Bag(folder).files == before


def test_messages_of_others_are_saved_as_they_are(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / "other", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/chatter", "std_msgs/msg/String", typestore=store)
        for number in range(5):
            data = store.serialize_cdr(store.types["std_msgs/msg/String"](data=f"{number}"), "std_msgs/msg/String")
            writer.write(connection, number, data)
    found = recover(tmp_path / "other")
    assert (found.messages, found.steps) == (5, 0)
    with AnyReader([found.path]) as reader:
        told = [reader.deserialize(data, connection.msgtype).data for connection, _, data in reader.messages()]
    assert told == ["0", "1", "2", "3", "4"]


def test_nothing_is_overwritten(tmp_path, whole):
    content, _ = whole
    path = tmp_path / "run.mcap"
    path.write_bytes(content)
    (tmp_path / "run_recovered").mkdir()
    (tmp_path / "run_recovered" / "mine").write_text("mine")
    for out in (None, path):
        with pytest.raises(InputError, match="exists already"):
            recover(path, out)
    assert path.read_bytes() == content
    assert (tmp_path / "run_recovered" / "mine").read_text() == "mine"


@pytest.mark.parametrize(
    ("content", "status", "told"),
    [
        (b"", 1, "holds nothing that can be saved"),
        (b"\x89MCAP0\r\n", 1, "holds nothing that can be saved"),
        (b"speed: 3\n" * 100, 2, "is neither MCAP nor SQLite"),
        (bytes(5000), 2, "is neither MCAP nor SQLite"),
    ],
)
def test_other_files_leave_nothing_behind(tmp_path, capsys, content, status, told):
    (tmp_path / "run.mcap").write_bytes(content)
    assert main(["recover", str(tmp_path / "run.mcap")]) == status
    assert told in capsys.readouterr().err
    assert [item.name for item in tmp_path.iterdir()] == ["run.mcap"]


def test_the_command_tells_what_was_saved_and_lost(tmp_path, whole, capsys):
    content, _ = whole
    (tmp_path / "run.mcap").write_bytes(content[: len(content) // 2])
    assert main(["recover", str(tmp_path / "run.mcap")]) == 0
    out = capsys.readouterr().out
    assert "lost: run.mcap: bytes" in out
    assert "the file ends within a chunk" in out
    assert f"bag   {tmp_path / 'run_recovered'}" in out
    assert main(["recover", str(tmp_path / "run.mcap")]) == 2
    assert main(["recover", str(tmp_path / "none")]) == 2


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path, whole):
    (tmp_path / "run.mcap").write_bytes(whole[0])
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match=r"cannot be saved to .*file/new"):
        recover(tmp_path / "run.mcap", tmp_path / "file" / "new")
    assert {item.name for item in tmp_path.iterdir()} == {"run.mcap", "file"}


def test_overview_of_a_damaged_bag_is_that_of_the_recovered(tmp_path, whole):
    content, _ = whole
    path = tmp_path / "run.mcap"
    half = len(content) // 2
    path.write_bytes(content[:half] + b"\0" + content[half + 1 :])
    found, again = overview(path), overview(recover(path).path)
    assert found.summary == again.summary
    assert (found.steps, found.gaps, found.revisions) == (again.steps, again.gaps, again.revisions)
    assert len(found.losses) == 2
    assert again.losses == again.gaps
