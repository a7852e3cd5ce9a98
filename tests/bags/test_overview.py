import dataclasses
import json
import math
from pathlib import Path

import pytest

from wheelset_track_sim.bags import BagWriter, read_bag
from wheelset_track_sim.bags.bag_file import BagFile
from wheelset_track_sim.bags.mcap.reader import Chunk, McapReader
from wheelset_track_sim.bags.overview import ChangedKey, changed_keys, overview, revisions_of
from wheelset_track_sim.bags.run_info import Input
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import RecordingError
from wheelset_track_sim.samples.block import NO_CONTACTS, ContactCounts
from wheelset_track_sim.scenario import load_scenario


def copied(path, *groups):
    """A bag of messages, each group of which is a chunk."""
    file = BagFile(path, 0, {})
    for group in groups:
        for message in group:
            file.add(message.topic, message.log_time, message.data)
        file.flush()
    file.finish()
    return path


def stored(path):
    """Messages of a bag."""
    with path.open("rb") as stream:
        source = McapReader(stream, path.name, pytest.fail)
        return [message for chunk in source.scan() if isinstance(chunk, Chunk) for message in source.messages(chunk)]


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
    found, recording = overview(bag), read_bag(bag)
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
    assert (first.number, first.step, first.changed) == (0, 0, ())
    assert (second.number, second.step) == (1, 1390)
    assert second.changed == (ChangedKey("speed", 27.7777778, 1e3 / 36),)


def test_a_bag_without_summaries_is_looked_through(bag, tmp_path):
    messages = [message for file in sorted(bag.glob("*.mcap")) for message in stored(file)]
    found = overview(
        copied(tmp_path / "samples.mcap", [message for message in messages if "Summary" not in message.topic.type])
    )
    assert math.isnan(found.summary.contacts.largest_estimate)  # which samples do not tell
    assert dataclasses.replace(found.summary, contacts=NO_CONTACTS) == overview(bag).summary
    assert found.steps == overview(bag).steps
    assert found.info.scenario_name == "undamaged"


def test_contacts_are_counted_over_all_chunks(tmp_path, run_info, run_blocks, make_state, capsys):
    path = tmp_path / "counted.mcap"
    with BagWriter(path, run_info, start_ns=0) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block, counts in zip(run_blocks, ((3, 40, 12.5), (0, 70, 80.0), (9, 0, 0.0)), strict=False):
            writer.write(dataclasses.replace(block, contacts=ContactCounts(*counts)))
    assert overview(path).summary.contacts == ContactCounts(12, 110, 80.0)
    assert main(["info", str(path), "--json"]) == 0
    counted = {"solved_steps": 12, "filtered_steps": 110, "largest_estimate_N": 80.0}
    assert json.loads(capsys.readouterr().out)["contact"] == counted
    assert main(["info", str(path)]) == 0
    assert "110 filtered" in capsys.readouterr().out


def test_of_older_bags_it_is_not_known_how_contacts_were_found(capsys):
    bag = Path(__file__).parents[1] / "data" / "damage_wheel_1_of_0_1.mcap"
    assert math.isnan(overview(bag).summary.contacts.largest_estimate)
    assert main(["info", str(bag), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["contact"] == {}


def test_gaps_and_missing_files_are_told(bag, run_blocks):
    (bag / "run_0.mcap").unlink()
    found = overview(bag)
    assert not found.complete
    assert [str(loss) for loss in found.losses] == ["run_0.mcap: it is missing"]
    assert found.first_step == 1390


@pytest.mark.parametrize("summaries", [True, False])
def test_a_gap_is_told_once_with_summaries_or_without(tmp_path, run_info, run_blocks, summaries):
    path = tmp_path / "run.mcap"
    with BagWriter(path, run_info, start_ns=0) as writer:
        for block in (run_blocks[0], run_blocks[2]):
            writer.write(block)
    messages = [message for message in stored(path) if summaries or "Summary" not in message.topic.type]
    found = overview(copied(tmp_path / "gap.mcap", messages))
    assert [str(loss) for loss in found.losses] == ["steps 1389 to 1389 are missing (3.6e-05 s)"]
    assert found.steps == 1389 + 700


@pytest.mark.parametrize("summaries", [True, False])
def test_another_run_does_not_count_and_is_told(bag, tmp_path, summaries):
    """As when ``ros2 bag record`` goes on while the node is reset: the second run goes on where the first one ended."""
    runs = [*(stored(file) for file in sorted(bag.glob("*.mcap")))]
    first, rest = ([m for m in run if summaries or "Summary" not in m.topic.type] for run in runs)
    path = copied(tmp_path / "twice.mcap", first, first, rest)
    again = "twice.mcap: steps from 0 on come again after step 1389: all that follows is left out"
    found = overview(path)
    assert (found.steps, found.first_step) == (1390, 0)
    assert [str(loss) for loss in found.losses] == [again]
    losses = []
    assert len(read_bag(path, lost=losses.append)) == 1390
    assert [str(loss) for loss in losses] == [again]


def test_a_bag_of_two_wheelsets_is_refused(tmp_path, run_info, run_blocks, make_state, capsys):
    """Who takes the forces of one for those of the other tells wrong numbers."""
    messages = []
    for wheelset in ("wheelset_1", "wheelset_2"):
        path = tmp_path / f"{wheelset}.mcap"
        with BagWriter(path, run_info, start_ns=0, prefix=f"/{wheelset}") as writer:
            writer.write_state(make_state(run_blocks[0]))
            writer.write(run_blocks[0])
        messages += stored(path)
    both = copied(tmp_path / "both.mcap", sorted(messages, key=lambda message: message.log_time))
    refusal = r"both.mcap holds 2 runs \(/wheelset_1/contact_forces, /wheelset_2/contact_forces\): record each"
    with pytest.raises(RecordingError, match=refusal):
        read_bag(both)
    content = both.read_bytes()
    both.write_bytes(content[: len(content) - 400])  # without its index
    with pytest.raises(RecordingError, match=refusal):
        read_bag(both, lost=[].append)
    assert main(["info", str(both)]) == 1
    assert "both.mcap holds 2 runs" in capsys.readouterr().err


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
    assert main(["info", str(tmp_path / "none")]) == 2
    assert "does not exist" in capsys.readouterr().err


def test_differences_are_keys_of_scenarios():
    before = load_scenario("damage_wheel_1")
    after = load_scenario("damage_wheel_1", ["irregularities.0.h=0.001", "speed=30"])
    assert changed_keys(before.to_yaml(), after.to_yaml()) == (
        ChangedKey("speed", before.speed, 30),
        ChangedKey("irregularities.0.h", 0.002, 0.001),
    )
    assert changed_keys(before.to_yaml(), before.to_yaml()) == ()
    (removed,) = changed_keys(before.to_yaml(), dataclasses.replace(before, irregularities=()).to_yaml())
    assert removed.key == "irregularities.0"
    assert removed.after is None
    assert changed_keys("a: 1", "a: [") == (ChangedKey("scenario", "a: 1", "a: ["),)


def test_each_revision_once_in_their_order():
    told = [Input(1, 50, "a: 2"), Input(0, 0, "a: 1"), Input(1, 80, "a: 2"), Input(3, 90, "a: 2\nb: {c: 1}")]
    found = revisions_of(told)
    assert [(item.number, item.step) for item in found] == [(0, 0), (1, 50), (3, 90)]
    assert [item.changed for item in found] == [(), (("a", 1, 2),), (("b", None, {"c": 1}),)]


def test_a_bag_of_each_tenth_step_is_complete_and_says_so(tmp_path, run_info, make_block):
    path = tmp_path / "thin.mcap"
    with BagWriter(path, run_info, start_ns=0) as writer:
        for first in (0, 2000, 4000):
            block = make_block(first, 200, time=first * 3.6e-5)
            writer.write(dataclasses.replace(block, decimation=10, step_period=10 * block.step_period))
    found = overview(path)
    assert found.complete, found.losses
    assert found.steps == 6000
    assert found.duration == pytest.approx(6000 * 36e-6, rel=1e-6)
    assert any("they do not have samples at each step" in line for line in found.unchecked)
    thin = [message for message in stored(path) if message.log_time != round(2000 * 36e-6 * 1e9)]
    gap = overview(copied(tmp_path / "gap.mcap", thin))
    assert [str(loss).partition(" (")[0] for loss in gap.gaps] == ["steps 2000 to 3999 are missing"]


def test_events_to_come_are_counted() -> None:
    before = load_scenario("undamaged", ["events=[{time: 1.0, speed: 30.0}, {time: 2.0, axle_load: 2e5}]"])
    after = dataclasses.replace(before, speed=30.0, events=before.events[1:])
    assert changed_keys(before.to_yaml(), after.to_yaml())[-1] == ChangedKey("events to come", 2, 1)
    last = dataclasses.replace(after, axle_load=2e5, events=())
    assert changed_keys(after.to_yaml(), last.to_yaml())[-1] == ChangedKey("events to come", 1, 0)
