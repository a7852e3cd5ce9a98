"""A detector beside the track of a running node: one message when the wheelset has passed, the same as in bags."""

import json

import numpy as np
import pytest

pytestmark = [pytest.mark.ros, pytest.mark.slow]

SCENARIO = """
name: passing
speed: 27.7777778
axle_load: 196200.0
irregularities:
  - {type: breakout, on: wheel_1, a: 0.03, b: 0.024, h: 0.002}
wayside:
  - {detector: shear_single, position: 1.8}
  - {detector: shear_single, position: 9.0, name: second}
"""


def test_a_reading_is_published_when_the_wheelset_has_passed_the_same_as_from_the_bag(start, client, tmp_path, capsys):
    from wheelset_track_sim.bags import read_bag
    from wheelset_track_sim.cli import main
    from wheelset_track_sim.twin import resimulate

    file, bag = tmp_path / "passing.yaml", tmp_path / "bags" / "passing"
    file.write_text(SCENARIO)
    first, second = (client.collect(f"wayside/{name}", "WaysideReading") for name in ("shear_single", "second"))
    node = start(
        scenario=file,
        autostart="false",
        record__directory=bag.parent,
        record__name=bag.name,
        record__on_start="true",
        duration=0.6,
    )
    client.until(lambda: client.state() == "unconfigured")
    assert client.transition("configure")
    for name in ("shear_single", "second"):
        client.until(lambda name=name: client.node.count_publishers(f"{client.name}/wayside/{name}"))
    assert client.transition("activate")
    client.until(lambda: first and second)
    assert node.wait() == 0, node.errors
    assert (len(first), len(second)) == (1, 1)
    recorded = read_bag(bag)
    capsys.readouterr()
    assert main(["wayside", str(bag), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["detectors"]
    for message, topic, entries in ((first[0], "shear_single", found[:2]), (second[0], "second", found[2:])):
        values = recorded.sensors[f"wayside/{topic}/shear_bridge"].values
        np.testing.assert_array_equal(np.concatenate([*values.values()]), message.values)
        assert [*message.mean_force] == [each["mean_N"] for each in entries]
        assert [*message.peak_force] == [each["peak_N"] for each in entries]
        assert [*message.true_peak_force] == [each["true_peak_N"] for each in entries]
        assert (message.detector, [*message.types]) == ("shear_single", ["shear_bridge"] * 2)
    assert second[0].detector_position == 9.0
    assert resimulate(bag).identical
