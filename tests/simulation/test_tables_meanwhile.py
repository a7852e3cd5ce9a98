"""Force tables of a changed defect are built while the stream goes on; they take effect at a step, whole."""

import dataclasses
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

from support.advancing import advance_to
from wheelset_track_sim.contact import tables
from wheelset_track_sim.errors import ContactError
from wheelset_track_sim.irregularities import Breakout, Flat
from wheelset_track_sim.scenario import WHEELS, Scenario
from wheelset_track_sim.simulation.simulator import Simulator

SMALL = {"a": 0.006, "b": 0.005, "h": 0.0002}
PATIENCE = 60.0


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch, smooth: Simulator) -> None:
    """Models from the user's cache, tables from nowhere."""
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path))
    monkeypatch.setattr(tables, "_RECENT", tables._Recent(100))


def forces_to(simulator: Simulator, step: int) -> np.ndarray:
    return np.concatenate([block.forces for block in advance_to(simulator, step)])


def with_defects(scenario: Scenario, *defects: Breakout) -> Scenario:
    return dataclasses.replace(scenario, irregularities=defects)


def test_the_stream_goes_on_while_tables_are_built(smooth: Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()
    build = tables.force_path

    def held(*arguments):
        begun.set()
        assert go_on.wait(PATIENCE)
        return build(*arguments)

    monkeypatch.setattr(tables, "force_path", held)
    models, changed = smooth.models, with_defects(smooth.scenario, Breakout("wheel_1", **SMALL))
    with ThreadPoolExecutor(1) as pool:
        change = pool.submit(smooth.apply, changed)
        assert begun.wait(PATIENCE)
        blocks = advance_to(smooth, 1000, 100)
        assert {block.revision for block in blocks} == {0}
        go_on.set()
        revision = change.result(PATIENCE)
    assert revision.step == 1000
    streamed = forces_to(smooth, 2500)

    synchronous = Simulator(with_defects(changed), models=models)
    advance_to(synchronous, 1000)
    synchronous.apply(changed)
    assert np.array_equal(forces_to(synchronous, 2500), streamed)
    assert np.abs(np.diff(streamed[:, 0])).max() > 1e3  # the defect is there


def test_a_table_that_cannot_be_built_leaves_the_run_as_it_is(smooth: Simulator, monkeypatch) -> None:
    monkeypatch.setattr(tables, "force_path", lambda *arguments: np.array([[0.0, 0.0], [np.nan, 1.0]]))
    before = smooth.scenario
    with pytest.raises(ContactError, match="not finite"):
        smooth.apply(with_defects(before, Breakout("wheel_1", **SMALL)))
    assert smooth.scenario == before
    assert smooth.advance(10).revision == 0


OVERLAPPING = Breakout("wheel_1", **SMALL), Breakout("wheel_1", 0.004, 0.004, 0.0003, angle=0.008, y=0.001)
BOTH_WHEELS = Breakout("wheel_1", **SMALL), Breakout("wheel_2", 0.005, 0.004, 0.0003, angle=0.004, y=-0.001)


@pytest.mark.parametrize(
    "defects",
    [
        pytest.param(OVERLAPPING, marks=pytest.mark.slow),
        BOTH_WHEELS,
        pytest.param(OVERLAPPING + BOTH_WHEELS[1:], marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_overlapping_defects_and_defects_of_both_wheels_come_as_the_solver_has_them(
    smooth: Simulator, defects: tuple[Breakout, ...]
) -> None:
    changed = with_defects(smooth.scenario, *defects)
    models = dataclasses.replace(smooth.models, tables="smooth", _smooth=None)
    solved = Simulator(smooth.scenario, models=models)
    found = []
    for simulator in (smooth, solved):
        advance_to(simulator, 1700)
        assert simulator.apply(changed).step == 1700
        found.append(forces_to(simulator, 1950))
    assert (smooth._changes.in_force.law.table >= 0).all()
    assert (solved._changes.in_force.law.table < 0).any()
    assert np.abs(found[0] - found[1]).max() < 1e-3
    for wheel in {defect.on for defect in defects}:
        force = found[0][:, WHEELS.index(wheel)]
        assert np.abs(np.diff(force)).max() > 1e3  # the defect is there


def test_a_change_back_is_there_without_building(smooth: Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    plain, changed = smooth.scenario, with_defects(smooth.scenario, Breakout("wheel_2", **SMALL))
    smooth.apply(changed)
    smooth.apply(plain)
    monkeypatch.setattr(tables, "force_path", lambda *arguments: pytest.fail("built again"))
    assert smooth.apply(changed).number == 3


def test_tables_are_the_same_on_any_number_of_cores(
    smooth: Simulator, monkeypatch: pytest.MonkeyPatch, tmp_path
) -> None:
    """They are built side by side, each curve by itself."""
    flat = (Flat("wheel_1", length=0.03),)
    found = []
    for cores in (1, 3):
        monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path / str(cores)))
        monkeypatch.setattr(tables, "_RECENT", tables._Recent(100))
        monkeypatch.setattr(tables, "cores", partial(int, cores))
        found.append(smooth.models.contact_law(flat))
    for name in ("first_point", "points", "table"):
        assert np.array_equal(getattr(found[0], name), getattr(found[1], name))


def test_a_change_that_is_broken_off_builds_no_further(smooth: Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "cores", lambda: 1)

    def stop(stage: str, fraction: float) -> None:
        raise KeyboardInterrupt

    built = []
    build = tables.force_path
    monkeypatch.setattr(tables, "force_path", lambda *arguments: (built.append(1), build(*arguments))[1])
    with pytest.raises(KeyboardInterrupt):
        smooth.models.contact_law((Flat("wheel_1", length=0.02),), stop)
    assert len(built) < 10
