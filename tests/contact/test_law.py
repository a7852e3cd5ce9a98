import tracemalloc
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelset_track_sim.contact import (
    ContactGeometry,
    approach_for_force,
    build_contact_law,
    contact_force,
    force_at,
    solve_patch,
    tables,
)
from wheelset_track_sim.contact.law import TABLE_FORCE
from wheelset_track_sim.contact.law_kernels import (
    solve_contact,
    solved_force,
    table_force,
    tabulated_force,
    total_separation,
)
from wheelset_track_sim.contact.solutions import solver
from wheelset_track_sim.contact.tables import force_path
from wheelset_track_sim.errors import ContactError, InputError
from wheelset_track_sim.irregularities import Breakout, HeadDefect, Roughness
from wheelset_track_sim.runtime import cache
from wheelset_track_sim.runtime.jit import kernel

DX, N_C = 0.001, 2713
GEOMETRY = ContactGeometry()
DEFECTS = (
    Breakout("wheel_1", a=0.030, b=0.024, h=0.002),
    Breakout("wheel_2", a=0.020, b=0.010, h=0.0006, angle=1.0, y=0.004),
    Breakout("wheel_2", a=0.010, b=0.008, h=0.0003, angle=1.01),
)
AT = round(N_C / (2 * np.pi))


@pytest.fixture(scope="module", autouse=True)
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path_factory.mktemp("models")))
        yield


@pytest.fixture(scope="module")
def law():
    return build_contact_law(DEFECTS, GEOMETRY, DX, N_C)


@pytest.fixture(scope="module")
def plain():
    return build_contact_law(DEFECTS, GEOMETRY, DX, N_C, tables=False)


def assert_same(one, other):
    for mine, theirs in zip((*one, *one.nested[0]), (*other, *other.nested[0]), strict=True):
        if not isinstance(mine, tuple):
            np.testing.assert_array_equal(mine, theirs)


positions = st.one_of(st.tuples(st.just(0), st.integers(-70, 70)), st.tuples(st.just(1), st.integers(AT - 60, AT + 60)))


@pytest.mark.slow
@settings(deadline=None, max_examples=150)
@given(positions, st.floats(0, 0.98 * TABLE_FORCE), st.sampled_from([0.0, 1e-10, 1e-9]))
def test_tables_are_the_solver_without_its_cost(law, plain, where, force, compliance):
    approach = approach_for_force(law, *where, 0, force, compliance)
    tabulated = tabulated_force(law, *where, 0, approach, compliance)
    assert tabulated == pytest.approx(force, abs=1e-6)
    assert contact_force(plain, *where, 0, approach, compliance) == pytest.approx(tabulated, abs=1e-6)


@pytest.mark.slow
def test_smooth_treads_share_one_table_and_both_wheels_theirs(law):
    assert (law.table >= 0).all()
    assert (law.table[0, 100:-100] == 0).all()
    assert (law.table[1, :300] == 0).all()
    # The breakout is symmetric along the tread, so positions ahead and behind share tables.
    assert (law.table[0, 1:60] == law.table[0, :-60:-1]).all()
    again = build_contact_law(
        [Breakout("wheel_1", 0.02, 0.01, 0.001), Breakout("wheel_2", 0.02, 0.01, 0.001, angle=2.0)], GEOMETRY, DX, N_C
    )
    assert len(set(again.table[0]) ^ set(again.table[1])) == 0


def test_beyond_the_tables_the_solver_takes_over(law):
    largest = law.points[law.first_point[1] - 1]
    assert largest[1] == pytest.approx(TABLE_FORCE)
    beyond = contact_force(law, 0, 1000, 0, largest[0] + 1e-6, 0.0)
    assert np.isnan(tabulated_force(law, 0, 1000, 0, largest[0] + 1e-6, 0.0))
    assert beyond == pytest.approx(TABLE_FORCE + 1e-6 * solve_patch(law, 0, 1000, 0, largest[0]).stiffness, rel=1e-4)


def test_loss_of_contact_is_exact(law):
    for tread in (0, 12, 1000):
        touch = total_separation(law, 0, tread, 0).min()
        for compliance in (0.0, 1e-9):
            assert contact_force(law, 0, tread, 0, touch, compliance) == 0.0
            assert contact_force(law, 0, tread, 0, -1.0, compliance) == 0.0
            assert 0 < contact_force(law, 0, tread, 0, touch + 1e-12, compliance) < 0.1


@pytest.mark.slow
def test_compliance_is_a_spring_in_series(law, plain):
    approach, compliance = 1.6e-3, 3e-10
    for each in (law, plain):
        force = contact_force(each, 0, 0, 0, approach, compliance)
        assert force > 10e3
        assert force == pytest.approx(contact_force(each, 0, 0, 0, approach - compliance * force, 0.0), rel=1e-10)


@pytest.mark.parametrize("compliance", [0.0, 1e-9])
@pytest.mark.parametrize("tread", [0, 25, 1000])
@pytest.mark.parametrize("force", [0.0, 1.0, 98e3, 350e3, 650e3])
def test_approach_for_force_inverts_the_law(law, plain, tread, force, compliance):
    for each in (law, plain):
        approach = approach_for_force(each, 0, tread, 0, force, compliance)
        assert force_at(each, 0, tread, 0, approach, compliance) == pytest.approx(force, rel=1e-9, abs=1e-4)


def test_depth_zero_changes_nothing():
    nothing = (Breakout("wheel_1", 0.03, 0.024, 0.0), Breakout("wheel_1", 0.02, 0.02, 0.0, angle=0.01, y=0.002))
    bare, zero = build_contact_law([], GEOMETRY, DX, N_C), build_contact_law(nothing, GEOMETRY, DX, N_C)
    assert_same(bare, zero)
    with_more = build_contact_law((*DEFECTS, *nothing), GEOMETRY, DX, N_C, tables=False)
    without = build_contact_law(DEFECTS, GEOMETRY, DX, N_C, tables=False)
    np.testing.assert_array_equal(with_more.tread, without.tread)


def test_indices_wrap(law):
    for step in (-N_C, N_C, 1000 * N_C):
        assert contact_force(law, 0, 5 + step, 5 + step, 1.4e-3, 0.0) == contact_force(law, 0, 5, 5, 1.4e-3, 0.0)


def test_an_element_ahead_meets_what_comes_next():
    law = build_contact_law([Breakout("wheel_1", 0.005, 0.005, 0.001, angle=1.0)], GEOMETRY, DX, N_C, tables=False)
    widened = total_separation(law, 0, AT - 10, 0) - law.separation[0]
    i, j = np.unravel_index(np.argmax(widened), widened.shape)
    assert widened[i, j] == pytest.approx(0.001)
    assert law.x[i] == pytest.approx(0.010)
    assert law.y[0, j] == 0.0


class Dent(NamedTuple):
    """A trough across a rail."""

    on: str
    position: float

    def patches(self, surface, y):
        yield surface.around(
            surface.at(self.position), 0.020, lambda s: -1e-4 * np.exp(-((s / 0.005) ** 2)) * np.ones_like(y)
        )


def test_rail_heights_count_like_tread_heights():
    smooth = build_contact_law([], GEOMETRY, DX, N_C, tables=False)
    law = build_contact_law([Dent("rail_1", 0.3)], GEOMETRY, DX, N_C, rail_steps=600)
    # Along x the dent sits in the middle of the area at rail step 300, and again one bay on.
    at = contact_force(law, 0, 0, 300, 2e-4, 0.0)
    assert at < 0.9 * contact_force(law, 0, 0, 0, 2e-4, 0.0)
    assert contact_force(law, 0, 7, 900, 2e-4, 0.0) == at
    assert contact_force(law, 1, 0, 300, 2e-4, 0.0) == pytest.approx(contact_force(smooth, 1, 0, 0, 2e-4, 0.0))
    gap = total_separation(law, 0, 0, 290) - law.separation[0]
    assert law.x[np.argmax(gap[:, 3])] == pytest.approx(0.010)
    assert gap.max() == pytest.approx(1e-4)
    # The dent has tables, of which the two sides share each, and the treads keep theirs.
    assert (law.table == 0).all()
    assert (law.rail_table[1] == 0).all()
    assert (law.rail_table[0, 301:330] == law.rail_table[0, 299:270:-1]).all()
    assert law.rail_table[0, 300] > 0 == law.rail_table[0, 100]
    assert len(law.nested[0].element) == 0
    assert law.rail_mirrored.all()


def test_a_long_line_takes_memory_where_it_is_not_smooth():
    far = HeadDefect("rail_1", position=900.0, a=0.02, b=0.01, h=1e-4, y=0.002)
    tracemalloc.start()
    built = build_contact_law([far], ContactGeometry(), 1e-3, 2713, rail_steps=1_000_000, tables=False)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert built.rail_mirrored.tolist() == [False, True]
    assert peak < 250e6  # all of its heights are 440 MB


def test_a_tread_that_is_rough_all_around_has_no_tables():
    treads = [Roughness("wheel_1"), Breakout("wheel_2", 0.003, 0.003, 1e-4)]
    law = build_contact_law(treads, GEOMETRY, DX, N_C)
    assert (law.table[0] == -1).all()
    assert (law.table[1] >= 0).all()
    assert 1 < len(law.first_point) - 1 < 50
    assert not law.tread_mirrored[0].any()
    assert law.tread_mirrored[1].all()


def test_called_by_its_address_the_solver_is_the_same(law):
    call = (law, 0, 1000, 0, 1e-4, 0.0, law.in_contact[0], np.empty((0, 0)))
    assert solver(law) is solver(law._replace(in_contact=law.in_contact.copy()))
    assert through(solver(law), *call) == solve_contact(*call)


@kernel
def through(solver, law, wheel, tread, rail, approach, compliance, in_contact, pressure):
    return solver(law, wheel, tread, rail, approach, compliance, in_contact, pressure)


def test_pressure_sums_to_the_force_and_leaves_the_state(law, plain):
    contact_force(plain, 0, 10, 0, 1.4e-3, 0.0)
    state = plain.in_contact.copy()
    pressure = solve_patch(plain, 0, -20, 0, 1.5e-3, 1e-10).pressure
    assert (plain.in_contact == state).all()
    assert pressure.sum() * law.element_area == pytest.approx(contact_force(law, 0, -20, 0, 1.5e-3, 1e-10), rel=1e-9)


@kernel
def passage(law, first, steps, forces):
    for step in range(first, first + steps):
        for wheel in range(2):
            forces[step, wheel] = contact_force(law, wheel, step, step, 1.2e-4 + 2e-5 * np.sin(0.05 * step), 1e-10)


@pytest.mark.slow
def test_chunks_do_not_change_a_bit():
    def run(chunk):
        law = build_contact_law(DEFECTS, GEOMETRY, DX, N_C, tables=False)
        forces = np.full((600, 2), np.nan)
        for first in range(0, 600, chunk):
            passage(law, first, min(chunk, 600 - first), forces)
        return forces

    whole = run(600)
    assert np.isfinite(whole).all()
    assert (whole[:20] == 0).any()
    for chunk in (1, 32, 137):
        assert (run(chunk) == whole).all()


@pytest.mark.slow
def test_nan_stays_nan_and_python_raises():
    law = build_contact_law(DEFECTS[:1], GEOMETRY, 2 * DX, N_C // 2)  # an approach beyond its border is solved quickly
    assert np.isnan(contact_force(law, 0, 0, 0, np.nan, 0.0))
    assert np.isnan(contact_force(law, 0, 0, 0, 1e-3, np.nan))
    assert np.isnan(solved_force(law, 0, 0, 0, 0.1, 0.0))
    with pytest.raises(ContactError, match=r"wheel_1 at tread step 0.*approach 0\.1 m.*border"):
        force_at(law, 0, 0, 0, 0.1)
    with pytest.raises(ContactError, match="the inputs are not finite"):
        solve_patch(law, 0, 0, 0, np.nan)
    with pytest.raises(ContactError, match="cannot carry"):
        approach_for_force(law, 0, 0, 0, 1e12)
    with pytest.raises(InputError, match="force = -1 N"):
        approach_for_force(law, 0, 0, 0, -1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"dx": 0.0}, "dx = 0"),
        ({"dy": np.nan}, "dy = nan"),
        ({"largest_force": 1e9}, "largest_force"),
        ({"n_c": 3}, "n_c"),
    ],
)
def test_senseless_grids_are_refused(change, words):
    given = {"irregularities": (), "geometry": GEOMETRY, "dx": DX, "n_c": N_C} | change
    with pytest.raises(InputError, match=words):
        build_contact_law(**given)


@pytest.mark.slow
def test_a_change_of_one_defect_builds_no_table_of_another(tmp_path, monkeypatch):
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path))
    built = []

    def counted(*arguments):
        built.append(arguments)
        return force_path(*arguments)

    monkeypatch.setattr(tables, "force_path", counted)
    monkeypatch.setattr(tables, "_RECENT", tables._Recent(100))
    stays = Breakout("wheel_1", 0.008, 0.006, 0.0004)
    both = build_contact_law([stays, Breakout("wheel_2", 0.006, 0.005, 0.0003)], GEOMETRY, DX, N_C)
    assert len(built) == len(both.first_point) - 1
    before = {number for number in both.table[0] if number}
    built.clear()
    other = build_contact_law([stays, Breakout("wheel_2", 0.005, 0.005, 0.0002)], GEOMETRY, DX, N_C)
    assert 0 < len(built) == len(other.first_point) - 2 - len(before)
    for number in before:
        assert (both.points[both.first_point[number]] == other.points[other.first_point[number]]).all()


def test_tables_are_cached_and_progress_is_told(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path))
    told = []
    defect = Breakout("wheel_2", 0.01, 0.008, 0.0003)
    first = build_contact_law([defect], GEOMETRY, DX, N_C, progress=lambda stage, share: told.append(share))
    assert told == sorted(told)
    assert told[-1] == 1.0
    told.clear()
    second = build_contact_law([defect], GEOMETRY, DX, N_C, progress=lambda stage, share: told.append(share))
    assert not told
    assert_same(first, second)
    stored = next(cache.folder().glob("force-tables-*.npz"))
    stored.write_bytes(b"damaged")
    third = build_contact_law([defect], GEOMETRY, DX, N_C, progress=lambda stage, share: told.append(share))
    assert told[-1] == 1.0
    assert "built again" in caplog.text
    np.testing.assert_array_equal(third.points, first.points)


@given(st.floats(0, 1e-3), st.floats(0, 1e-8))
def test_lookup_solves_its_equation(approach, compliance):
    points = np.array([[1e-4, 0.0], [2e-4, 1e4], [3e-4, 1e5]])
    force = table_force(points, 0, 3, approach, compliance)
    if approach - compliance * 1e5 > 3e-4:
        assert np.isnan(force)
    else:
        expected = np.interp(approach - compliance * force, points[:, 0], points[:, 1])
        assert force == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.slow
@settings(deadline=None, max_examples=8)
@given(
    st.floats(0.003, 0.06), st.floats(0.002, 0.03), st.floats(0, 0.003), st.floats(-0.015, 0.015), st.integers(-80, 80)
)
def test_any_breakout_has_tables_like_the_solver(a, b, h, y, tread):
    defect = Breakout("wheel_1", a, b, h, y=y)
    law = build_contact_law([defect], GEOMETRY, DX, N_C)
    plain = law._replace(table=np.full_like(law.table, -1))
    for force in (1e3, 100e3, 400e3):
        approach = approach_for_force(law, 0, tread, 0, force)
        assert contact_force(plain, 0, tread, 0, approach, 0.0) == pytest.approx(force, abs=1e-5)


def test_approach_for_force_where_the_approach_is_next_to_zero():
    """Raised surfaces touch before their nominal ones do: at 98 kN the approach may be anything, also nothing."""
    smooth = build_contact_law([], GEOMETRY, DX, N_C, tables=False)
    at = approach_for_force(smooth, 0, 0, 0, 98e3)
    for raised in (at, at * (1 + 1e-9), 1e-3):
        law = smooth._replace(tread=smooth.tread + raised, tread_top=smooth.tread_top + raised)
        assert approach_for_force(law, 0, 0, 0, 98e3) == pytest.approx(at - raised, abs=1e-17)
