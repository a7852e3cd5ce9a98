"""Recorded runs simulated again from their bags."""

import dataclasses
import random
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.bags import Bag, BagWriter, RunInfo, read_bag
from wheelset_track_sim.bags.run_info import Input
from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.irregularities import Breakout, Harmonic, Polygon, Squat
from wheelset_track_sim.live.run_messages import record, run_info, state, states
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import WHEELS, Scenario, load_scenario
from wheelset_track_sim.scenario.loads import Loads
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin import resimulate

SHAPES = ((0.004, 0.008, 0.0005), (0.006, 0.012, 0.001), (0.006, 0.012, 0.0002))
TURN = 2713


def recorded(path: Path, simulator: Simulator, plan: Sequence[tuple[int, dict[str, object]]], end: int) -> Path:
    """Bag of a run with changes that are accepted at steps."""
    with record(path, simulator) as push:

        def run_to(step: int) -> None:
            while simulator.next_step < step:
                block = simulator.advance(min(1000, step - simulator.next_step))
                push(block, summarise(block))

        for step, values in plan:
            run_to(step)
            simulator.apply(dataclasses.replace(simulator.scenario, **values))  # type: ignore[arg-type]
        run_to(end)
        while simulator.scenario != simulator.in_force:  # until all have taken effect
            run_to(simulator.next_step + TURN)
    return path


def defect(on: str = "wheel_1", angle: float = 0.0, h: float = 0.001) -> Breakout:
    return Breakout(on=on, a=0.006, b=0.012, h=h, angle=angle)  # type: ignore[arg-type]


PLAN: tuple[tuple[int, dict[str, object]], ...] = (
    (700, {"speed": 30.0, "acceleration": 8.0}),
    (700, {"axle_load": 180e3}),
    (1500, {"irregularities": (defect(),)}),
    (1500, {"axle_load": 210e3, "irregularities": (defect(), defect("wheel_2", 1.0))}),
    (4000, {"speed": 27.0}),
)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bag") / "run.mcap", Simulator(load_scenario("undamaged")), PLAN, 3 * TURN)


@pytest.mark.slow
def test_the_same_inputs_give_the_same_bits(bag: Path, tmp_path: Path) -> None:
    found = resimulate(bag, out=tmp_path / "again.mcap")
    assert found.identical
    assert not found.origin
    assert found.samples == 3 * TURN
    assert found.before == found.after
    assert [change.revision for change in found.inputs.changes] == [*range(6)]
    first, second = read_bag(bag), read_bag(tmp_path / "again.mcap")
    for name in ("steps", "time", "speed", "revision", "forces", "stresses"):
        np.testing.assert_array_equal(getattr(second, name), getattr(first, name))
    for one, other in zip(second.states, first.states, strict=True):
        assert dataclasses.replace(one, real_time_factor=0.0) == dataclasses.replace(other, real_time_factor=0.0)
    assert second.info == first.info


@pytest.mark.slow
def test_a_run_of_events_and_changes_gives_the_same_bits(tmp_path: Path) -> None:
    """Events are recorded as the revisions that they have become, and do not happen a second time."""
    events = (
        "events=[{distance: 0.4, irregularities: [{type: breakout, on: wheel_1, a: 0.006, b: 0.012, h: 0.0005}]}, "
        "{step: 600, speed: 30, acceleration: 8}, {turn: 0.5, axle_load: 180e3}, "
        "{time: 0.06, grow: {key: irregularities.0.h, to: 0.001, over: 3, steps: 1}}, {distance: 99, torque: 1 kN m}]"
    )
    live = (2000, {"acceleration": 5.0})
    bag = recorded(tmp_path / "run.mcap", Simulator(load_scenario("undamaged", [events])), [live], 2 * TURN)
    found = resimulate(bag, out=tmp_path / "again.mcap")
    assert found.identical
    assert not found.unknown
    assert [change.revision for change in found.inputs.changes] == [*range(7)]
    depths = [getattr(change.scenario.irregularities[-1], "h", 0.0) for change in found.inputs.changes[1:]]
    assert (depths[0], depths[-1]) == (0.0005, 0.001)
    first, second = read_bag(bag), read_bag(tmp_path / "again.mcap")
    np.testing.assert_array_equal(second.forces, first.forces)
    with pytest.raises(InputError, match=r"^--set events: events cannot be set for a recorded run"):
        resimulate(bag, ["events=[]"])


@pytest.mark.slow
def test_bits_are_the_same_after_a_hundred_random_revisions(tmp_path: Path) -> None:
    """Depth, size, place, kind and number of defects, load, torque, speed and acceleration; several at one step."""
    seed = random.SystemRandom().randrange(2**32)
    chance = random.Random(seed)

    def damage() -> tuple[Breakout, ...]:
        return tuple(
            Breakout(chance.choice(WHEELS), *chance.choice(SHAPES), angle=chance.uniform(0.0, 6.28))
            for _ in range(chance.randrange(4))
        )

    def irregularities() -> tuple[object, ...]:
        """Breakouts, also beside what never leaves the patch: then they fade."""
        squat = Squat("rail_1", position=chance.uniform(0.0, 50.0), a=0.006, b=0.012, h=0.0005)
        polygon = Polygon("wheel_2", (Harmonic(chance.randrange(1, 4), chance.choice((2e-5, 5e-5))),))
        return (*damage(), *chance.choice([()] * 6 + [(squat,), (polygon,)]))

    draw: tuple[Callable[[], dict[str, object]], ...] = (
        lambda: {"irregularities": irregularities()},
        lambda: {"axle_load": chance.uniform(150e3, 250e3)},
        lambda: {"loads": Loads(torque=chance.uniform(-5e3, 5e3))},
        lambda: {"speed": chance.uniform(20.0, 35.0), "acceleration": chance.uniform(0.5, 10.0)},
    )
    plan, step = [], 0
    for _ in range(100):
        step += chance.choice((0, chance.randrange(1, 900)))
        kinds = chance.sample(draw, chance.choice((1, 1, 3)))
        plan.append((step, {key: value for kind in kinds for key, value in kind().items()}))
    simulator = Simulator(load_scenario("undamaged"))
    found = resimulate(recorded(tmp_path / "run.mcap", simulator, plan, step + TURN))
    assert simulator.revision == 100, f"seed {seed}"
    assert len(found.inputs.changes) == 101, f"seed {seed}"
    assert found.identical, f"seed {seed}"
    assert found.after.wheels[0].max_force > 1.1 * found.after.wheels[0].mean_force, f"seed {seed}"


@pytest.mark.parametrize("scenario", [pytest.param("rough_wheel", marks=pytest.mark.slow), "line_speeds", "slab_track"])
def test_other_scenarios_give_the_same_bits_too(tmp_path: Path, scenario: str) -> None:
    simulator = Simulator(load_scenario(scenario))
    assert resimulate(recorded(tmp_path / "run.mcap", simulator, [(997, {"axle_load": 180e3})], 3000)).identical


def test_a_run_under_a_vehicle_gives_the_same_bits_and_its_bag_names_the_vehicle(tmp_path: Path) -> None:
    simulator = Simulator(load_scenario("damage_wheel_1", ["vehicle=power_car", "vehicle.bogie_mass=1500"]))
    bag = recorded(tmp_path / "run.mcap", simulator, [(997, {"axle_load": 180e3})], 2000)
    assert set(Bag(bag).info.models) == {"wheelset", "track", "vehicle"}
    assert resimulate(bag).identical
    found = resimulate(bag, ["vehicle.bogie_mass=700"])
    assert not found.identical


@pytest.mark.slow
def test_a_part_of_a_bag_is_simulated_from_the_start_of_its_run(tmp_path: Path) -> None:
    simulator = Simulator(load_scenario("undamaged"))
    with BagWriter(tmp_path / "run", run_info(simulator), start_ns=5) as writer:
        writer.write_state(state(simulator))
        for number, load in enumerate((180e3, 190e3, 200e3)):
            simulator.apply(dataclasses.replace(simulator.scenario, axle_load=load))
            block = simulator.advance(900)
            [told] = states(simulator, block.first_step, number)
            writer.write_state(told)
            writer.write(block)
            if number < 2:
                writer.split()
    for number in range(3):
        part = tmp_path / "run" / f"run_{number}.mcap"
        assert Bag(part).info.inputs[0].revision == 0
        found = resimulate(part)
        assert found.identical
        assert found.inputs.start is None
        assert found.samples == 900


def test_a_recording_that_was_started_late_is_simulated_from_the_start_of_its_run(tmp_path: Path) -> None:
    simulator = Simulator(load_scenario("undamaged"))
    simulator.apply(dataclasses.replace(simulator.scenario, axle_load=180e3, speed=29.0))
    simulator.advance(1500)
    bag = recorded(tmp_path / "late", simulator, [(1800, {"axle_load": 190e3})], 4000)
    assert read_bag(bag).steps[0] == 1500
    assert resimulate(bag).identical


def without_inputs(path: Path, source: Path, first_step: int) -> Path:
    """The bag as ``ros2 bag record`` makes it when it is started late: no metadata, and the latched state first."""
    bag = Bag(source)
    info = RunInfo("undamaged", "", "", 0.6, versions={})
    with BagWriter(path, info, start_ns=0) as writer:
        past = [each for each in bag.states if each.first_step <= first_step]
        writer.write_state(past[-1])
        for block in bag.blocks():
            if block.first_step >= first_step:
                for each in bag.states:
                    if each.first_step == block.first_step and each not in past:
                        writer.write_state(each)
                writer.write(block)
    return path


@pytest.mark.slow
def test_a_run_whose_beginning_is_unknown_settles(tmp_path: Path) -> None:
    """Defect, sleepers and speed are met at the right places: once the unknown state is over both runs agree."""
    source = recorded(
        tmp_path / "run.mcap",
        Simulator(load_scenario("undamaged")),
        [(2000, {"irregularities": (defect(),)}), (3000, {"axle_load": 180e3})],
        20 * TURN,
    )
    found = resimulate(without_inputs(tmp_path / "late.mcap", source, 3000))
    assert not found.identical
    assert found.inputs.start is not None
    assert found.inputs.start.step == 3000
    assert found.force is not None
    assert found.force.last_beyond is not None
    assert found.force.largest > 1e3  # the load that rose when the bag begins is taken for one that was there
    assert 0.9 < found.force.last_beyond.time < 1.6
    assert found.samples > 15 * TURN


@pytest.mark.slow
def test_what_would_have_been(bag: Path) -> None:
    damage = ["irregularities=[{type: breakout, on: wheel_1, a: 0.03, b: 0.024, h: 0.001}]"]
    deeper = resimulate(bag, [*damage, "settle_on=smooth"])
    assert not deeper.identical
    assert deeper.force is not None
    assert deeper.force.signal == "wheel_1"
    assert deeper.after.wheels[0].max_force > 1.5 * deeper.before.wheels[0].max_force
    assert 1700 < deeper.force.first.step < 1800  # where the defect first meets the rail, which was smooth until then
    running = resimulate(bag, damage)
    assert running.force is not None
    assert running.force.first.step == 0  # the wheel has run on the defect before
    assert resimulate(bag, ["axle_load=210e3"]).after.wheels[0].mean_force == pytest.approx(105e3, rel=0.01)


@pytest.mark.slow
def test_another_speed_is_compared_at_the_same_places(bag: Path) -> None:
    slower = resimulate(bag, ["speed=20"])
    assert slower.samples == 3 * TURN
    assert not slower.moved
    scenario: Scenario = slower.inputs.changes[0].scenario
    assert scenario.speed != 20  # what was recorded is told as it was


@pytest.mark.slow
def test_what_differs_here_is_named(bag: Path, tmp_path: Path) -> None:
    found = Bag(bag)
    info = dataclasses.replace(
        found.info, versions={**found.info.versions, "numpy": "1.0", "cpu": "abacus"}, models={"track": "other"}
    )
    with BagWriter(tmp_path / "other.mcap", info, start_ns=0) as writer:
        for event in found.events():
            if isinstance(event, type(found.states[0])):
                writer.write_state(event)
            else:
                writer.write(event)
    again = resimulate(tmp_path / "other.mcap")
    assert again.identical
    assert again.origin.keys() == {"numpy", "cpu", "track"}
    assert again.origin["numpy"][0] == "1.0"


def test_bags_that_do_not_say_what_went_in_are_refused(bag: Path, tmp_path: Path) -> None:
    info = RunInfo("undamaged", "", "", 0.6)
    with BagWriter(tmp_path / "none.mcap", info, start_ns=0) as writer:
        for block in Bag(bag).blocks():
            writer.write(block)
    with pytest.raises(RecordingError, match="does not say what was simulated"):
        resimulate(tmp_path / "none.mcap")
    broken = dataclasses.replace(info, inputs=(Input(0, 0, "name: a\nspeed: fast\n"),))
    with BagWriter(tmp_path / "broken.mcap", broken, start_ns=0) as writer:
        writer.write(next(Bag(bag).blocks()))
    with pytest.raises(RecordingError, match=r"revision 0 .*speed = 'fast'"):
        resimulate(tmp_path / "broken.mcap")


@pytest.mark.slow
def test_a_damaged_bag_is_compared_as_far_as_it_can_be_read(bag: Path, tmp_path: Path) -> None:
    data = bytearray(bag.read_bytes())
    for place in range(len(data) // 2, len(data) // 2 + 64):
        data[place] ^= 0xFF
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data)
    found = resimulate(broken, out=tmp_path / "whole.mcap")
    assert found.lost
    assert 0 < found.samples < 3 * TURN
    assert found.identical == (not found.unknown)
    assert (
        len(read_bag(tmp_path / "whole.mcap")) >= found.samples
    )  # what is missing in between is simulated all the same
