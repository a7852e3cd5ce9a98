"""What went into a run, in the metadata of each file of its bag."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.bags import RunInfo
from wheelset_track_sim.bags.run_info import MOST, Input, decode_inputs, encode_inputs, versions
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.live.run_messages import run_info, state, states
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.simulation.simulator import Simulator

INPUTS = st.lists(st.builds(Input, st.integers(0, 2**32 - 1), st.integers(0, 2**63), st.text()), max_size=5)


@given(INPUTS)
def test_inputs_come_back_from_their_text(inputs: list[Input]) -> None:
    assert decode_inputs(encode_inputs(inputs)) == tuple(inputs)


@pytest.mark.parametrize("text", ["", "no base64", "AAAA", "eJyrVkrLz1eyUkpKLFKqBQAdAgQU"])
def test_damaged_text_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match="inputs of the run"):
        decode_inputs(text)


def test_many_changes_of_much_the_same_take_little_space() -> None:
    scenario = load_scenario("damage_both").to_yaml()
    inputs = [Input(number, 997 * number, scenario.replace("0.002", f"{number * 1e-6!r}")) for number in range(1000)]
    assert len(encode_inputs(inputs)) < 0.1 * sum(len(each.scenario) for each in inputs)


def test_an_input_is_kept_once_and_the_earliest_are_forgotten() -> None:
    info = RunInfo("a", "name: a\n", "0f", 0.6)
    for number in (0, 0, 1, 2, 1, 2):  # told again at a pause, and in the next file
        info = info.with_input(Input(number, 10 * number, ""))
    assert [each.revision for each in info.inputs] == [0, 1, 2]
    full = dataclasses.replace(info, inputs=tuple(Input(number, number, "") for number in range(MOST)))
    assert [each.revision for each in full.with_input(Input(MOST, MOST, "")).inputs][:: MOST - 1] == [1, MOST]


def test_the_record_of_a_run_comes_back_whole() -> None:
    info = RunInfo("a", "name: a\n", "0f", 0.6, models={"track": "ab"}, inputs=(Input(0, 0, "name: a\n"),))
    assert RunInfo.from_metadata(info.to_metadata()) == info
    bare = dataclasses.replace(info, models={}, inputs=())
    assert RunInfo.from_metadata(bare.to_metadata()) == bare
    assert {"sources", "numpy", "blas", "cpu"} < versions().keys()


@pytest.mark.slow
def test_all_changes_are_told_also_those_at_one_step() -> None:
    simulator = Simulator(load_scenario("damage_wheel_1"))
    simulator.advance(500)
    loads = (190e3, 200e3, 180e3)
    for load in loads:
        revision = simulator.apply(dataclasses.replace(simulator.scenario, axle_load=load))
        assert revision.step == 500
    simulator.advance(10)
    told = states(simulator, 500, after=0)
    assert [(each.revision, each.first_step, each.axle_load) for each in told] == [
        (number, 500, load) for number, load in enumerate(loads, start=1)
    ]
    assert dataclasses.replace(state(simulator), first_step=500, time=told[-1].time, position=0.5) == told[-1]
    inputs = run_info(simulator).inputs
    assert [(each.revision, each.step) for each in inputs] == [(0, 0), (1, 500), (2, 500), (3, 500)]
    assert scenario_from(parse(inputs[-1].scenario, "")) == simulator.in_force
