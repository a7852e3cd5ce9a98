"""Fatigue of a running node: its topic, its services, its ledger, and the same damage from its bag."""

import json
import signal

import pytest

from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.cli.fatigue import counted
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.ledger import load_ledger

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


def test_live_damage_is_that_of_the_bag(start, client, tmp_path, capsys):
    from std_srvs.srv import Trigger
    from wheelset_track_msgs.srv import GetSpectrum

    reports = client.collect("fatigue", "Fatigue")
    node = start(
        scenario="damage_wheel_1",
        fatigue__curve="assumed_body",
        fatigue__axle="axle_7",
        fatigue__ledger=str(tmp_path / "axle.ledger"),
        fatigue__angles=8,
        real_time_factor=5.0,
        record__on_start="true",
        record__directory=str(tmp_path),
        record__name="run.mcap",
    )
    client.until(lambda: reports)
    assert client.call("pause", Trigger).success
    found = client.call("get_spectrum", GetSpectrum, node="A1", worst=True)
    assert found.success
    assert len(found.half_cycles) == found.rows * found.columns
    assert sum(found.half_cycles) > 0
    assert not client.call("get_spectrum", GetSpectrum, node="Z9").success
    saved = client.call("save_fatigue", Trigger)
    assert (saved.success, saved.message) == (True, str(tmp_path / "axle.ledger"))
    assert node.signal(signal.SIGINT) == 0
    told = reports[-1]
    assert (told.axle, told.curve, told.curve_assumed) == ("axle_7", "assumed_body", True)
    assert [*told.nodes] == ["A1", "B1", "C1"]
    assert told.ratio[0] > 2
    bag, ledger = str(tmp_path / "run.mcap"), tmp_path / "axle.ledger"
    curve = load_curve("assumed_body")
    at_report, _ = counted(bag, [], curve, told.distance, angles=8, gate=None)
    assert at_report.steps == told.next_step
    assert [*told.damage] == at_report.damage.ravel().tolist()  # bit by bit
    whole, _ = counted(bag, [], curve, None, angles=8, gate=None)
    (entry,) = load_ledger(ledger).entries
    assert (entry.axle, entry.run, entry.steps, bool(entry.state)) == ("axle_7", told.run, found.next_step, False)
    assert entry.damage.tobytes() == whole.damage.tobytes()
    assert main(["fatigue", bag, "--angles", "8", "--ledger", str(ledger), "--axle", "axle_7", "--json"]) == 0
    assert "are not added again" in json.loads(capsys.readouterr().out)["warnings"][0]


def test_without_a_curve_nothing_is_counted(start, client):
    from std_srvs.srv import Trigger

    forces = client.collect("contact_forces", "ContactForces")
    start(scenario="undamaged")
    client.until(lambda: forces)
    answer = client.call("save_fatigue", Trigger)
    assert not answer.success
    assert answer.message == "fatigue is not counted: start the node with fatigue.curve, such as assumed_body"


def test_a_curve_that_is_not_there_ends_the_node_with_one_line(start):
    node = start(scenario="undamaged", fatigue__curve="steel")
    assert node.wait() == 2
    assert "steel" in node.errors
