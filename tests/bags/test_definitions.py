"""Bags of other versions: their messages are read by the definitions that stand in them."""

import numpy as np
import pytest
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from wheelset_track_sim.bags import Bag, BagWriter, read_bag
from wheelset_track_sim.bags.definitions import DEFAULTS, full_name, schema, typestore
from wheelset_track_sim.bags.mcap.reader import McapReader
from wheelset_track_sim.bags.mcap.writer import McapWriter
from wheelset_track_sim.bags.run_info import METADATA_NAME
from wheelset_track_sim.errors import RecordingError


def recorded_with(path, changed, source):
    """The bag ``source`` as a version would have written it whose definitions are ``changed`` (kind: (old, new))."""
    store = get_typestore(Stores.EMPTY)
    texts = {}
    for kind in ("ContactForces", "AxleStress", "LoadSummary", "SimulationState"):
        texts[kind] = schema(kind)
        for old, new in changed.get(kind, ()):
            assert old in texts[kind]
            texts[kind] = texts[kind].replace(old, new)
        if kind not in changed:
            assert texts[kind] == schema(kind)
        store.register(get_types_from_msg(texts[kind], full_name(kind)))
    info = Bag(source).info
    record = {**info.to_metadata(), "version.wheelset_track_sim": "0.0.7"}
    record.pop("crc32")
    with source.open("rb") as stream, path.open("xb") as out:
        file = McapWriter(out, "ros2", "test")
        file.add_metadata(METADATA_NAME, record)
        channels = {}
        reading = McapReader(stream, source.name, pytest.fail)
        for chunk in reading.chunks_at(part.place for part in reading.layout.parts):
            for message in reading.messages(chunk):
                name, topic = message.topic.type, message.topic.name
                if topic not in channels:
                    number = file.add_schema(name, "ros2msg", texts[name.rpartition("/")[2]].encode())
                    channels[topic] = file.add_channel(topic, "cdr", number, {})
                found = typestore().deserialize_cdr(message.data, name)
                file.add_message(channels[topic], message.log_time, message.sequence, older(store, name, found))
        file.finish()
    return path


def older(store, name, found):
    """CDR of a message by other definitions: fields by name, what they have more is 7."""

    def converted(of, value):
        fields = {field: getattr(value, field, 7) for field in store.types[of].__dataclass_fields__ if field[0] != "_"}
        fields = {field: kept for field, kept in fields.items() if not field.isupper()}
        if "node" in fields and dict(store.fielddefs[of][1])["node"][0] == Nodetype.SEQUENCE:
            fields["node"] = np.frombuffer(fields["node"].encode(), np.uint8)
        if "damage" in fields:
            fields["damage"] = [converted(full_name("TreadDamage"), item) for item in fields["damage"]]
        return store.types[of](**fields)

    return bytes(store.serialize_cdr(converted(name, found), name))


@pytest.fixture
def bag(tmp_path, run_info, run_blocks, make_state):
    path = tmp_path / "run.mcap"
    with BagWriter(path, run_info, start_ns=0) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks:
            writer.write(block)
    return path


def without(kind, *fields):
    lines = [
        line for line in schema(kind).splitlines(keepends=True) if line.split(" ")[1:2] and line.split()[1] in fields
    ]
    assert len(lines) == len(fields)
    return {kind: [(line, "") for line in lines]}


def test_fields_that_an_older_version_did_not_have_are_as_they_were_then(bag, tmp_path):
    changed = without("ContactForces", "decimation") | without("SimulationState", "speed_set_point")
    found, expected = read_bag(recorded_with(tmp_path / "old.mcap", changed, bag)), read_bag(bag)
    assert found.forces.tobytes() == expected.forces.tobytes()
    assert found.stresses.tobytes() == expected.stresses.tobytes()
    assert [state.speed_set_point for state in found.states] == [state.speed for state in found.states]
    assert [state.damage for state in found.states] == [state.damage for state in expected.states]


def test_fields_of_a_newer_version_are_left_out(bag, tmp_path):
    changed = {
        "AxleStress": [("float64[] xx ", "float64 temperature\nfloat64[] xx ")],
        "SimulationState": [("float64 a ", "float64 depth_rate\nfloat64 a ")],
    }
    found, expected = read_bag(recorded_with(tmp_path / "new.mcap", changed, bag)), read_bag(bag)
    assert found.stresses.tobytes() == expected.stresses.tobytes()
    assert found.states == expected.states


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (lambda: without("ContactForces", "time"), "whose ContactForces has no time"),
        (lambda: {"AxleStress": [("string node ", "uint8[] node ")]}, "whose AxleStress has another type of node"),
        (lambda: without("SimulationState", "h"), "whose TreadDamage has no h"),
    ],
)
def test_what_nothing_can_stand_for_is_refused_with_the_version(bag, tmp_path, changed, words):
    path = recorded_with(tmp_path / "old.mcap", changed(), bag)
    with pytest.raises(RecordingError, match=f"recorded by wheelset_track_sim 0.0.7, {words}: read it") as error:
        read_bag(path)
    assert "\n" not in str(error.value)


def test_defaults_are_of_fields_that_there_are():
    for kind, fields in DEFAULTS.items():
        assert set(fields) <= {name for name, _ in typestore().fielddefs[full_name(kind)][1]}


def test_defaults_that_follow_from_the_message(bag):
    class Older:
        nodes = ("A1", "B1")

    assert np.isnan(DEFAULTS["LoadSummary"]["max_principal_rms"](Older)).tolist() == [True, True]
