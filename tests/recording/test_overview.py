import dataclasses
import json

import pytest

from wheelset_track_sim.cli import main
from wheelset_track_sim.recording import BagWriter, read
from wheelset_track_sim.recording.bag_copy import BagCopy
from wheelset_track_sim.recording.inputs import Input
from wheelset_track_sim.recording.mcap_records import Chunk
from wheelset_track_sim.recording.mcap_source import McapSource
from wheelset_track_sim.recording.overview import overview
from wheelset_track_sim.recording.revisions import Difference, differences, revisions
from wheelset_track_sim.scenario import load_scenario


@pytest.fixture
def bag(tmp_path, run_info, run_blocks, make_state):
    path = tmp_path / "run"
    with BagWriter(path, run_info, start_ns=10**18) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks[:2]:
            writer.write(block)
        writer.split()
        writer.write_state(make_state(run_blocks[2]))
        writer.write(run_blocks[2])
    return path


def test_it_is_what_the_samples_say(bag, run_info):
    found, recording = overview(bag), read(bag)
    assert (found.first_step, found.steps, found.start) == (0, len(recording), 0.0)
    assert found.duration == pytest.approx(recording.time[-1] + recording.step_period[-1], rel=1e-12)
    assert found.start_ns == recording.start_ns
    assert found.info == run_info
    assert found.summary is not None
    for wheel, expected in zip(found.summary.wheels, recording.summary.wheels, strict=True):
        assert (wheel.max_force, wheel.min_force) == (expected.max_force, expected.min_force)
        assert wheel.contact_loss == pytest.approx(expected.contact_loss, rel=1e-12)
    for node, expected in zip(found.summary.nodes, recording.summary.nodes, strict=True):
        assert (node.max_principal, node.min_principal) == (expected.max_principal, expected.min_principal)
    assert found.topics["/wheelset_track_sim/summary"] == ("wheelset_track_msgs/msg/LoadSummary", 3)
    assert list(found.files) == ["run_0.mcap", "run_1.mcap"]
    assert found.complete
    (first, second) = found.revisions
    assert (first.number, first.step, first.differences) == (0, 0, ())
    assert (second.number, second.step) == (1, 1390)
    assert second.differences == (Difference("speed", 27.7777778, 1e3 / 36),)


def test_a_bag_without_summaries_is_looked_through(bag, tmp_path):
    copy = BagCopy(tmp_path / "samples.mcap")
    for file in sorted(bag.glob("*.mcap")):
        with file.open("rb") as stream:
            source = McapSource(stream, file.name)
            for chunk in source.scan():
                if isinstance(chunk, Chunk):
                    copy.write([m for m in source.messages(chunk) if "Summary" not in m.schema.name], None)
    copy.finish()
    found = overview(tmp_path / "samples.mcap")
    assert found.summary == overview(bag).summary
    assert found.steps == overview(bag).steps
    assert found.info.scenario_name == "undamaged"


def test_gaps_and_missing_files_are_told(bag, run_blocks):
    (bag / "run_0.mcap").unlink()
    found = overview(bag)
    assert not found.complete
    assert [str(loss) for loss in found.losses] == ["run_0.mcap: it is missing"]
    assert found.first_step == 1390


def test_the_command_prints_one_json_object(bag, capsys):
    assert main(["info", str(bag), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["complete"] is True
    assert found["steps"] == 2090
    assert found["revisions"][1] == {"revision": 1, "step": 1390, "changed": {"speed": [27.7777778, 1e3 / 36]}}
    assert set(found["wheels"]["wheel_2"]) == {"max_force_N", "min_force_N", "contact_loss_s", "impacts"}
    assert set(found["nodes"]) == {"A1", "B1", "C1"}
    assert found["gaps"] == found["damage"] == []


def test_the_command_prints_tables(bag, capsys):
    (bag / "run_1.mcap").write_bytes(b"")
    assert main(["info", str(bag)]) == 0
    out = capsys.readouterr().out
    assert "1390, from 0 to 1389" in out
    assert "lost: run_1.mcap: it is empty" in out


def test_what_is_no_bag(tmp_path, capsys):
    assert main(["info", str(tmp_path / "none")]) == 1
    assert "does not exist" in capsys.readouterr().err


def test_differences_are_keys_of_scenarios():
    before = load_scenario("damage_wheel_1")
    after = load_scenario("damage_wheel_1", ["irregularities.0.h=0.001", "speed=30"])
    assert differences(before.to_yaml(), after.to_yaml()) == (
        Difference("speed", before.speed, 30),
        Difference("irregularities.0.h", 0.002, 0.001),
    )
    assert differences(before.to_yaml(), before.to_yaml()) == ()
    (removed,) = differences(before.to_yaml(), dataclasses.replace(before, irregularities=()).to_yaml())
    assert removed.key == "irregularities.0"
    assert removed.after is None
    assert differences("a: 1", "a: [") == (Difference("scenario", "a: 1", "a: ["),)


def test_each_revision_once_in_their_order():
    told = [Input(1, 50, "a: 2"), Input(0, 0, "a: 1"), Input(1, 80, "a: 2"), Input(3, 90, "a: 2\nb: {c: 1}")]
    found = revisions(told)
    assert [(item.number, item.step) for item in found] == [(0, 0), (1, 50), (3, 90)]
    assert [item.differences for item in found] == [(), (("a", 1, 2),), (("b", None, {"c": 1}),)]
