"""A run whose end another client asks for meanwhile: no bag is left behind that nobody closes."""

import dataclasses

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.live.recorder import Recorder
from wheelset_track_sim.live.run_messages import PAUSED
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

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
