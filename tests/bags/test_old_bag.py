"""A bag that version 0.1.0 recorded: it is read, played and simulated again with the same numbers.

It holds 3000 steps of ``damage_wheel_1``. At step 1389 a client sets another speed (revision 1), and then replaces the
breakout by a shallower one and a flat (revision 2).
"""

import hashlib
import math

import pytest

from support.paths import OLD_BAG
from support.replaying import padded, recorded
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.bags.definitions import deserialise
from wheelset_track_sim.bags.messages import state_of
from wheelset_track_sim.bags.overview import ChangedKey, overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.playback.selection import Selection
from wheelset_track_sim.bags.run_info import versions
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.live.player import Playback, Player
from wheelset_track_sim.twin import resimulate

DIGESTS = {
    "steps": "e8c9ceaf5aacc63c",
    "time": "764f6eec3a55fcd4",
    "speed": "8a506d5079bf39ca",
    "forces": "37a7d6f89b80dcc3",
    "stresses": "e079b362d1cbdda0",
}
"""SHA-256 of the arrays as version 0.1.0 reads them."""
LIKE_BEFORE = 900
"""Bytes of a summary before the counts of contacts, which that version did not have."""
SOFTWARE = {"wheelset_track_sim", "sources", "wheelset", "track"}
"""What a later version of this package changes; all else belongs to the machine."""


def test_it_is_read_bit_by_bit():
    run = read_bag(OLD_BAG)
    assert {name: hashlib.sha256(getattr(run, name).tobytes()).hexdigest()[:16] for name in DIGESTS} == DIGESTS
    assert run.info.versions["wheelset_track_sim"] == "0.1.0"
    assert [(state.revision, state.first_step) for state in run.states] == [(0, 0), (1, 1389), (2, 1389)]
    found = overview(OLD_BAG)
    assert found.complete
    assert found.impacts == (1, 1)
    assert found.revisions[1].changed == (ChangedKey("speed", 27.7777778, 28.5),)
    assert [change.key for change in found.revisions[2].changed] == ["irregularities.0.h", "irregularities.1"]


def test_it_is_played_message_by_message():
    states = read_bag(OLD_BAG).states
    with RecordedBag(OLD_BAG) as bag:
        assert not any(topic.outdated for topic in bag.topics.values())
        played, ends = [], []
        selection = Selection(bag, bag.topics)
        Player(selection, Playback(rate=0.0), lambda item, _: played.append(item), lambda *_: None, ends.append).run()
        assert ends == [None]
        stored = recorded(OLD_BAG)
        assert [(item.time_ns, item.topic) for item in played] == [each[:2] for each in stored]
        for item, (_, topic, cdr, *_) in zip(played, stored, strict=True):
            if topic.endswith("/state"):  # as a subscriber of this version reads it
                found = deserialise("SimulationState", item.cdr)
                assert str(state_of(found)) in {str(state) for state in states}
                assert len(parse(found.irregularities, "irregularities")) == 1 + (found.revision == 2)
            elif topic.endswith("/summary"):
                found = deserialise("LoadSummary", item.cdr)
                assert (found.solved_steps, found.filtered_steps) == (0, 0)
                assert math.isnan(found.largest_estimate)
                assert padded(item.cdr)[:LIKE_BEFORE] == cdr[:LIKE_BEFORE]
            else:
                assert padded(item.cdr) == cdr
        assert sum(item.begins for item in played) == 3


@pytest.mark.slow
def test_it_is_simulated_again_with_equal_numbers_by_another_version():
    found = resimulate(OLD_BAG)
    assert found.samples == 3000
    assert not found.moved
    assert found.origin["sources"] == ("a21a652ede07bb2b1a15ff42f8b8ee97", versions()["sources"])
    if found.origin.keys() <= SOFTWARE:  # the processor and the libraries that recorded it
        assert found.identical
    else:
        for difference, scale in ((found.force, 98.1e3), (found.stress, 66e6)):
            assert difference is None or difference.largest < 1e-6 * scale
