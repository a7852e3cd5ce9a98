"""Several wheelsets in one process: each streams, changes and records for itself, with the bits of a node alone."""

import signal
from itertools import pairwise
from queue import SimpleQueue

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.errors import ContactError, InputError

pytestmark = pytest.mark.ros

DAMAGE = {
    "leading": {"wheel_1.damage.h": 0.002},
    "middle": {"wheel_2.damage.h": 0.001, "wheel_2.damage.angle": 1.0},
    "trailing": {"axle_load": 180e3, "speed": 30.0},
}


def file_of(folder, **common):
    """Parameter file of the fleet: what all have in common, and what each has of its own."""
    lines = []
    for name, values in {"/**": {"scenario": "undamaged", **common}, **DAMAGE}.items():
        lines += [f"{name}:", "  ros__parameters:", *(f"    {key}: {value}" for key, value in values.items())]
    path = folder / "fleet.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


def started(start, file, names="leading,middle,trailing"):
    return start("--fleet", names, "--ros-args", "--params-file", str(file))


@pytest.fixture
def member(client):
    """View of one node of the fleet."""

    def view(name):
        other = type(client)(client.node, client.running)
        other.name = f"/{name}"
        return other

    return view


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_each_streams_without_gaps_and_changes_for_itself(start, member, tmp_path):
    views = {name: member(name) for name in DAMAGE}
    forces = {name: view.collect("contact_forces", "ContactForces") for name, view in views.items()}
    states = {name: view.collect("state", "SimulationState", latched=True) for name, view in views.items()}
    node = started(start, file_of(tmp_path))
    for name, view in views.items():
        view.until(lambda name=name: len(forces[name]) >= 5 and states[name])
    assert views["middle"].set(axle_load=150e3).successful
    views["middle"].until(lambda: forces["middle"][-1].revision == 1 and states["middle"][-1].revision == 1)
    assert views["leading"].transition("deactivate")
    seen = {name: len(found) for name, found in forces.items()}
    for name in ("middle", "trailing"):
        views[name].until(lambda name=name: len(forces[name]) >= seen[name] + 5)
    assert len(forces["leading"]) <= seen["leading"] + 1
    assert views["trailing"].get("axle_load", "wheel_1.damage.h") == [180e3, 0.0]
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors

    for chunks in forces.values():
        for before, after in pairwise(chunks):
            assert after.first_step == before.first_step + len(before.wheel_1)
    assert {chunk.revision for name in ("leading", "trailing") for chunk in forces[name]} == {0}
    damage = {name: [(item.wheel, item.h) for item in found[-1].damage] for name, found in states.items()}
    assert damage == {"leading": [(1, 0.002)], "middle": [(2, 0.001)], "trailing": []}
    assert {name: found[-1].axle_load for name, found in states.items()} == {
        "leading": 196.2e3,
        "middle": 150e3,
        "trailing": 180e3,
    }
    assert {forces[name][0].speed for name in DAMAGE} == {30.0, forces["leading"][0].speed}


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_each_has_the_bits_of_a_node_alone(start, tmp_path):
    run = {"duration": 0.5, "real_time_factor": 0.0, "record.on_start": "true", "record.directory": tmp_path}
    fleet = started(start, file_of(tmp_path, **run))
    assert fleet.wait() == 0, fleet.errors
    bags = {path.name.rpartition("_")[2]: path for path in tmp_path.glob("run_*")}
    assert set(bags) == set(DAMAGE)
    for name, values in DAMAGE.items():
        alone = start(**{"scenario": "undamaged", **run, **values, "record.name": f"alone_{name}"})
        assert alone.wait() == 0, alone.errors
        found, expected = read_bag(bags[name]), read_bag(tmp_path / f"alone_{name}")
        np.testing.assert_array_equal(found.forces, expected.forces)
        np.testing.assert_array_equal(found.stresses, expected.stresses)
        assert len(found) == round(0.5 / found.step_period[0])
        assert found.info.digest == expected.info.digest
    assert read_bag(bags["leading"]).forces.min(axis=0)[0] == 0.0  # its breakout has been on the rail


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_bad_parameters_of_one_end_all_with_one_line(start, tmp_path):
    file = file_of(tmp_path)
    file.write_text(file.read_text().replace("axle_load: 180000.0", "axle_load: -1.0"))
    node = started(start, file)
    assert node.wait() == 2
    assert "axle_load" in node.errors
    assert len(node.errors.strip().splitlines()) == 1


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_shipped_parameter_file(start, member):
    views = [member(f"wheelset_{number}") for number in (1, 2, 3)]
    forces = [view.collect("contact_forces", "ContactForces") for view in views]
    start("--fleet", "3", "--ros-args", "--params-file", str(ROOT / "config" / "fleet.yaml"))
    for view, found in zip(views, forces, strict=True):
        view.until(lambda found=found: found)
        assert found[0].decimation == 10
    assert views[0].get("wheel_1.damage.h", "axle_load") == [0.002, 196.2e3]
    assert views[2].get("speed") == [30.0]
    assert [view.get("scenario") for view in views] == [["undamaged"], ["flat_fresh"], ["damage_both"]]
    assert [found[0].header.frame_id for found in forces] == [f"wheelset_{number}/track" for number in (1, 2, 3)]


class Closing:
    def __init__(self):
        self.closed = False

    def close(self):
        self.closed = True


def ended(*endings):
    """Which of three nodes are closed, and the failure, after these endings."""
    from wheelset_track_sim.ros.process import Ending, _all

    queue, nodes = SimpleQueue(), [Closing() for _ in range(3)]
    for number, failure in endings:
        queue.put(Ending(number, failure))
    failure = _all(queue, nodes)
    return [node.closed for node in nodes], failure


def test_a_wheelset_that_cannot_go_on_leaves_the_others_running():
    failure = ContactError("no solution")
    assert ended((1, failure), (0, None), (2, None)) == ([True, True, True], failure)
    assert ended((1, failure), (None, None)) == ([False, True, False], failure)  # a signal ends the others
    assert ended((None, None)) == ([False] * 3, None)


def test_bad_input_of_one_ends_all():
    refusal = InputError("speed = 500")
    assert ended((2, None), (0, refusal)) == ([False, False, True], refusal)


def test_all_are_interrupted_before_one_is_waited_for():
    """The first may wait for models that the last one builds."""
    from wheelset_track_sim.ros.process import _close

    told = []

    class Node:
        def interrupt(self):
            told.append("interrupt")

        def close(self):
            told.append("close")

    _close([Node(), Node()])
    assert told == ["interrupt", "interrupt", "close", "close"]


@pytest.fixture
def fleet_names():
    from wheelset_track_sim.ros.process import fleet_names

    return fleet_names


def test_names(fleet_names):
    assert fleet_names("3") == ["wheelset_1", "wheelset_2", "wheelset_3"]
    assert fleet_names("leading") == ["leading"]
    assert fleet_names("a,b_2") == ["a", "b_2"]


@pytest.mark.parametrize("text", ["0", "-1", "101", "", "a,,b", "a,a", "2nd,b", "ä", "a b"])
def test_names_refused(fleet_names, text):
    with pytest.raises(InputError, match="--fleet"):
        fleet_names(text)
