import dataclasses

import numpy as np
import pytest

from support.advancing import advance_to
from wheelset_track_sim.dynamics.line import LineModel
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import Scenario, load_scenario, scenario_from
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.line import track_line
from wheelset_track_sim.track.track import load_track

STATIC = 98.1e3


def on_line(
    name: str = "undamaged", base: str = "ballasted_60e1", changes: tuple[str, ...] = (), **line: object
) -> Scenario:
    scenario = load_scenario(name, changes)
    return scenario_from({**scenario.to_mapping(), "track": {"base": base, "line": line}})


def forces_of(scenario: Scenario, steps: int) -> np.ndarray:
    simulator = Simulator(scenario)
    return np.concatenate([block.forces for block in advance_to(simulator, steps)])


@pytest.mark.parametrize("speed", [15.0, 27.7777778, 55.0])
@pytest.mark.slow
def test_equal_supports_give_the_forces_of_causal_dynamics(speed: float) -> None:
    changes = (f"speed={speed}",)
    line, causal = forces_of(on_line(changes=changes), 1200), forces_of(load_scenario("undamaged", changes), 1200)
    assert np.abs(line - causal).max() < 0.0025 * STATIC
    assert (line - causal).std() < 0.0005 * STATIC


@pytest.mark.slow
def test_equal_supports_give_the_impact_of_causal_dynamics() -> None:
    line, causal = forces_of(on_line("damage_wheel_1"), 2713), forces_of(load_scenario("damage_wheel_1"), 2713)
    assert line.max(axis=0) == pytest.approx(causal.max(axis=0), rel=0.006)
    assert (line - causal).std() < 0.002 * STATIC
    lost = [np.flatnonzero(forces[:, 0] == 0.0) for forces in (line, causal)]
    assert abs(len(lost[0]) - len(lost[1])) <= 1


@pytest.mark.slow
def test_slab_track_gives_the_forces_of_causal_dynamics() -> None:
    line = forces_of(on_line("slab_track", "slab_60e1"), 1300)
    causal = forces_of(load_scenario("slab_track"), 1300)
    assert np.abs(line - causal).max() < 0.0025 * STATIC


@pytest.mark.parametrize("step", [-5100, -6900, -8700, -5099, -300, 0, 900])
def test_a_run_begins_in_equilibrium_wherever_it_begins(step: int) -> None:
    """In the middle between two sleepers, too, which 5.1 m, 6.9 m and 8.7 m are but for their last bit."""
    model = load_models(on_line()).dynamics
    assert isinstance(model, LineModel)
    line = model.start(STATIC, step, 1e-3, 5.1)
    deflection = line.coming[1] + line.rail_compliance[0] * STATIC
    assert deflection == pytest.approx(model.line.compliance([step * 1e-3])[0] * STATIC, rel=0.01)


@pytest.mark.slow
def test_a_smooth_wheel_runs_smoothly_in_long_steps() -> None:
    """The contact's stiffness once drove bays whose frequencies reached what their steps bear: by 70 % of the load."""
    changes = ("axle_load=4e5", "speed=5.5", "irregularities=[]")
    forces = forces_of(on_line("trailer", "ballasted_54e1", changes), 3000)
    assert np.abs(forces - 200e3).max() < 0.015 * 200e3


def eventful(chunk: int) -> list:
    """A ramp of the speed over hanging sleepers, with damage on a wheel."""
    supports = [{"sleepers": "2-3", "gap": 2e-4}, {"sleepers": 5, "on": "rail_2", "pad_stiffness": 0.2}]
    simulator = Simulator(on_line("damage_wheel_1", changes=("acceleration=10",), supports=supports))
    blocks = advance_to(simulator, 500, chunk)
    simulator.apply(dataclasses.replace(simulator.scenario, speed=29.0))
    return blocks + advance_to(simulator, 5000, chunk)


@pytest.mark.slow
def test_any_chunk_length_gives_the_same_bits() -> None:
    whole = eventful(1389)
    assert len({block.speed for block in whole}) > 2
    for chunk in (7, 600):
        other = eventful(chunk)
        for name in ("forces", "stresses"):
            one, two = (np.concatenate([getattr(block, name) for block in blocks]) for blocks in (whole, other))
            assert np.array_equal(one, two)


@pytest.mark.slow
def test_a_speed_is_the_same_however_it_is_reached() -> None:
    supports = [{"sleepers": "30-40", "ballast_stiffness": 3.0}]
    changed = Simulator(on_line(changes=("speed=27", "acceleration=10"), supports=supports))
    changed.apply(dataclasses.replace(changed.scenario, speed=25.0))
    constant = Simulator(on_line(changes=("speed=25",), supports=supports))
    ends = []
    for simulator in (changed, constant):
        advance_to(simulator, 105 * 600)
        ends.append(np.concatenate([block.forces for block in advance_to(simulator, 115 * 600)]))
    assert np.ptp(ends[1]) > 5e3
    assert np.abs(ends[0] - ends[1]).max() < 20.0


@pytest.mark.slow
def test_force_is_continuous_where_the_speed_changes() -> None:
    """Against the same run without the change: the difference has no jump where the speed has one."""
    plain, changing = (Simulator(on_line(scatter={"ballast_stiffness": 0.3})) for _ in range(2))
    changing.apply(dataclasses.replace(changing.scenario, speed=28.2, acceleration=10.0))
    runs = [[simulator.advance(1)] for simulator in (plain, changing)]
    border = changing.course.stretches[1].step - 1  # the force of that step is that of the way there
    for simulator, blocks in zip((plain, changing), runs, strict=True):
        blocks += advance_to(simulator, border + 600)
    one, other = (np.concatenate([block.forces for block in blocks]) for blocks in runs)
    apart = np.abs(one - other)
    assert np.array_equal(one[: border + 1], other[: border + 1])
    assert np.abs(np.diff(one - other, axis=0))[border : border + 4].max() < 5e-5 * STATIC
    assert apart.max() > 50.0


@pytest.mark.slow
def test_a_line_repeats() -> None:
    simulator = Simulator(on_line(bays=48, scatter={"pad_stiffness": 0.2, "ballast_stiffness": 0.3}))
    advance_to(simulator, 4 * 48 * 600)
    first, second = (np.concatenate([b.forces for b in advance_to(simulator, n * 48 * 600)]) for n in (5, 6))
    assert np.abs(first - second).max() < 20.0
    assert np.ptp(first) > 8e3


@pytest.mark.slow
def test_a_hanging_sleeper_is_felt_and_holds_nothing_up() -> None:
    gaps = [None, 1e-4, 5e-3]
    dips = []
    for gap in gaps:
        simulator = Simulator(on_line(supports=[{"sleepers": "20-22", "gap": gap}] if gap else []))
        advance_to(simulator, 20 * 600)
        advance_to(simulator, 21 * 600, 600)
        dips.append(simulator.displacements[:, 1].max())
    assert dips[0] < dips[1] < dips[2]
    assert dips[1] - dips[0] == pytest.approx(1e-4, rel=0.3)  # the gap that closes
    model = simulator.models.dynamics
    assert isinstance(model, LineModel)
    line = model.line
    nothing = np.where(np.isnan(line.gap), line.ballast_stiffness, 1.0)
    bare = dataclasses.replace(line, ballast_stiffness=nothing, gap=np.full_like(line.gap, np.nan))
    assert dips[2] == pytest.approx(bare.compliance([21 * 0.6]).max() * STATIC, rel=0.05)


@pytest.mark.parametrize("name", ["hanging_sleeper", "stiffness_transition", "scattered_support", "slab_track"])
@pytest.mark.slow
def test_shipped_scenarios_run(name: str) -> None:
    forces = forces_of(load_scenario(name), 26 * 600)
    assert forces.min() > 0.8 * STATIC
    assert 2e3 < np.ptp(forces) < 0.2 * STATIC


@pytest.mark.slow
def test_what_steps_cannot_follow_is_refused() -> None:
    with pytest.raises(InputError, match=r"track\.line cannot be followed in paper dynamics"):
        Simulator(on_line(changes=("dynamics=paper",)))
    for changes in (("speed=5",), ("speed_plan=[{time: 9, speed: 5}]",)):
        with pytest.raises(
            InputError, match=r"speed = 5 m/s makes steps of 0\.4 ms, .* give 10 m/s or more, .* up to 0\.001 m"
        ):
            Simulator(on_line(changes=("step_length=0.002", *changes)))
    simulator = Simulator(on_line(changes=("step_length=0.002",)))
    with pytest.raises(InputError, match=r"speed = 9 m/s makes steps of 0\.222 ms"):
        simulator.apply(dataclasses.replace(simulator.scenario, speed=9.0))
    hangs = {"supports": [{"sleepers": 1, "gap": 0.0}]}
    track = {"base": "ballasted_60e1", "ballast": {"damping": 5e6}, "line": hangs}
    with pytest.raises(InputError, match=r"ballast damping of hanging sleepers, 5e\+06 N s/m, is too high"):
        scenario_from({**load_scenario("undamaged").to_mapping(), "track": track})


def test_the_line_is_what_the_supports_say() -> None:
    track = load_track({"base": "ballasted_60e1", "line": {"supports": [{"sleepers": 3, "ballast_damping": 2.0}]}})
    line = track_line(track)
    assert track.ballast is not None
    assert line.ballast_damping[2:4, 0] == pytest.approx(np.array([1.0, 2.0]) * track.ballast.damping)
    assert line.bays == 80
