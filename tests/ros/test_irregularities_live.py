"""Any irregularity, changed while the node runs."""

import math

import pytest

from support.service_calls import assert_gap_free, first_of
from wheelset_track_sim.errors import LONGEST
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import scenario_from

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


def irregularities(client, text):
    from wheelset_track_msgs.srv import SetIrregularities

    return client.call("set_irregularities", SetIrregularities, irregularities=text)


def test_any_irregularity_changes_live_and_goes_on_without_a_jump(start, client, forces, states, tmp_path):
    from std_msgs.msg import String

    (tmp_path / "below").mkdir()
    for path in (tmp_path / "outside.csv", tmp_path / "below" / "tread.csv"):
        path.write_text("".join(f"{angle},{0.02 * math.cos(math.radians(angle))}\n" for angle in range(360)))
    start(scenario="damage_wheel_1", profiles__directory=str(tmp_path / "below"))
    client.until(lambda: forces and states)
    kinds = (
        "[{type: breakout, on: wheel_2, a: 0.02, b: 0.01, h: 0.001, angle: 2.0},"
        " {type: squat, on: rail_1, position: 30.0, a: 0.02, b: 0.01, h: 0.0005},"
        " {type: polygon, on: wheel_1, harmonics: [{order: 3, amplitude: 1.0e-4}]}]"
    )
    answer = irregularities(client, kinds)
    assert (answer.success, answer.message, answer.revision) == (True, "", 1)
    client.until(lambda: forces[-1].revision == states[-1].revision == 1)
    assert first_of(forces, 1).first_step == answer.step == states[-1].first_step
    assert [(found.wheel, found.angle) for found in states[-1].damage] == [(2, 2.0)]
    assert [each.type for each in scenario_from(parse(states[-1].scenario, "state")).irregularities] == [
        "breakout",
        "squat",
        "polygon",
    ]
    assert client.get("wheel_1.damage.h", "wheel_2.damage.h") == [0.0, 0.001]
    # what cannot be used is refused whole, by name
    for text, words in (
        ("[{type: flat, on: wheel_1, length: 9.0}]", "irregularities.0.length = 9 m"),
        ("[{type: crater, on: wheel_1}]", "irregularities.0.type = 'crater'"),
        ("[&a [1], *a]", "alias"),
        ("[" * 200_000, "nested more than 20 times"),
        ("[{type: profile, on: wheel_1, file: ../outside.csv, along: deg, height: mm}]", "points outside"),
        (f"[{{type: profile, on: wheel_1, file: {tmp_path}/outside.csv, along: deg, height: mm}}]", "points outside"),
        ("#" * (256 * 1024 + 1), "give at most 262144"),
        ('[{type: breakout, "a\\nb": 1}]', r"irregularities.0.a\nb is not a known key"),
        (f"[{{type: breakout, on: {'A' * 200_000}}}]", "irregularities.0.on = 'AAA"),
    ):
        refused = irregularities(client, text)
        assert (refused.success, refused.revision) == (False, 1), text[:60]
        assert words in refused.message
        assert "\n" not in refused.message
        assert len(refused.message) <= LONGEST
    # a topic does the same; a file below the folder becomes part of the scenario
    publisher = client.node.create_publisher(String, f"{client.name}/cmd/irregularities", 1)
    client.until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data="[{type: profile, on: wheel_1, file: tread.csv, along: deg, height: mm}]"))
    client.until(lambda: forces[-1].revision == states[-1].revision == 2)
    assert "359.0 0.0199" in states[-1].scenario
    # tread damage replaces what is on the treads
    assert client.set(wheel_2__damage__h=0.0005).successful
    client.until(lambda: forces[-1].revision >= 3)
    assert_gap_free(forces)
    before, after = forces[-2], forces[-1]
    assert all(0.0 <= value < 4e5 for chunk in (before, after) for value in chunk.wheel_1)
