"""Runs that end or change while a bag is opened: no bag is left behind that nobody closes, and none lacks a change."""

import dataclasses

import pytest

from wheelset_track_sim.bags import Bag
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.live.recorder import Recorder
from wheelset_track_sim.live.run_messages import PAUSED, UNPACED
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin.run_inputs import run_inputs

pytestmark = pytest.mark.ros


class Outlet:
    """Topics, or what watches them: nothing to tell."""

    def publish(self, messages):
        assert list(messages) == []

    def finish(self):
        return []


@pytest.fixture
def recorder(monkeypatch, run_info):
    monkeypatch.setattr("wheelset_track_sim.live.recorder.run_info", lambda simulator: run_info)
    return Recorder("/wheelset_track_sim", print)


@pytest.fixture
def run(recorder):
    from wheelset_track_sim.ros.run import NodeRun

    return NodeRun(Simulator(load_scenario("undamaged")), Outlet(), Outlet(), recorder, None, None, None)


def test_a_run_that_is_over_begins_no_recording(run, recorder, tmp_path):
    opened = recorder.open

    def ended_meanwhile(*arguments):
        bag = opened(*arguments)
        run.end()
        return bag

    recorder.open = ended_meanwhile
    with pytest.raises(InputError, match="the run is over"):
        run.start_recording(tmp_path / "late")
    assert recorder.path == ""


def test_the_end_of_a_recording_is_told_no_more_when_the_run_is_over(run, recorder, tmp_path):
    run.start_recording(tmp_path / "run")
    run.messages.told = dataclasses.replace(run.messages.told, status=PAUSED)
    run.end()
    assert run.stop_recording() == str(tmp_path / "run")


class Anywhere:
    """Topics, monitoring and clock that take everything."""

    def __getattr__(self, name):
        return lambda *arguments: []


def test_a_change_while_a_bag_is_opened_is_recorded_with_its_step(tmp_path):
    from wheelset_track_sim.ros.run import NodeRun

    simulator, recorder = Simulator(load_scenario("undamaged")), Recorder("/wheelset_track_sim", print)
    run = NodeRun(simulator, Anywhere(), Anywhere(), recorder, Anywhere(), None, None)
    opened, loads = recorder.open, [190e3, 180e3]

    def deliver(steps):
        run._deliver(simulator.advance(steps), UNPACED)

    def changed_meanwhile(*arguments):
        bag = opened(*arguments)
        if loads:
            simulator.apply(dataclasses.replace(simulator.scenario, axle_load=loads.pop()))
            deliver(50)
            deliver(50)
        return bag

    recorder.open = changed_meanwhile
    assert run.start_recording(tmp_path / "late") == 200
    deliver(50)
    run.stop_recording()
    found = [(change.revision, change.step) for change in run_inputs(Bag(tmp_path / "late")).changes]
    assert found == [(0, 0), (1, 0), (2, 100)]
