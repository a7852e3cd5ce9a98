"""Contacts with a hardness: conditions, limits, guesses, tables."""

from functools import cache

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelset_track_sim.contact import (
    ContactGeometry,
    approach_for_force,
    build_contact_law,
    contact_force,
    force_at,
    solve_patch,
)
from wheelset_track_sim.contact.active_set_kernels import AT_BORDER, CONVERGED, solve_active_set
from wheelset_track_sim.contact.influence import influence_table
from wheelset_track_sim.contact.law_kernels import solve_bounded, tabulated_force, total_separation
from wheelset_track_sim.contact.tables import force_path
from wheelset_track_sim.contact.yielding_kernels import solve_yielding
from wheelset_track_sim.errors import ContactError
from wheelset_track_sim.irregularities import Breakout, Flat

DX, DY, H = 1e-3, 0.75e-3, 2.6e9
AREA = DX * DY
NX, NY = 21, 23
INFLUENCE = influence_table(NX, NY, DX, DY, 210e9, 0.3)
SHAPES = (Flat("wheel_1", 0.06), Breakout("wheel_2", 0.030, 0.024, 0.002))


@cache
def law(hardness=np.inf):
    return build_contact_law(SHAPES, ContactGeometry(), DX, 2713, hardness=hardness, tables=False)


@cache
def short_flat(hardness, tables):
    return build_contact_law(
        [Flat("wheel_1", 0.02)], ContactGeometry(), DX, 2713, largest_force=3e5, hardness=hardness, tables=tables
    )


def solved(gap, hardness, approach, compliance=0.0, *, mirrored=False, guess=None):
    pressure = np.empty(gap.shape)
    in_contact = np.zeros(gap.shape, bool) if guess is None else guess.copy()
    elastic = solve_active_set(gap, mirrored, INFLUENCE, AREA, approach, compliance, in_contact, pressure)
    if elastic[2] != CONVERGED:
        return *elastic, pressure, in_contact
    found = solve_yielding(gap, mirrored, INFLUENCE, AREA, approach, compliance, hardness, in_contact, pressure)
    return *found, pressure, in_contact


def rough(seed, height=5e-5, symmetric=False):
    x, y = (np.arange(NX) - NX // 2) * DX, (np.arange(NY) - NY // 2) * DY
    heights = height * np.random.default_rng(seed).standard_normal((NX, NY))
    if symmetric:
        heights += heights[:, ::-1]
    return x[:, None] ** 2 / 0.8 + y**2 / 0.5 + heights


def assert_conditions(gap, hardness, approach, compliance, force, pressure):
    """Every element is apart, bears elastically, or has yielded: with each element's influence on every other."""
    i, j = (index.ravel() for index in np.indices(gap.shape))
    p = pressure.ravel()
    full = INFLUENCE[abs(i[:, None] - i), abs(j[:, None] - j)]
    distance = gap.ravel() + full @ p - (approach - compliance * force)
    apart, yielded = p == 0, p == hardness
    assert (p >= 0).all()
    assert (p <= hardness).all()
    assert distance[apart].min(initial=0) > -1e-13
    assert np.abs(distance[~apart & ~yielded]).max(initial=0) < 1e-13
    assert distance[yielded].max(initial=0) < 1e-13
    np.testing.assert_allclose(force, p.sum() * AREA, rtol=1e-11)


@settings(deadline=None, max_examples=60)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(0, 1e-4),
    st.floats(2e-6, 1.5e-4),
    st.floats(1e8, 2e10),
    st.sampled_from((0.0, 1e-10, 1e-9)),
    st.booleans(),
)
def test_conditions_hold_on_random_heights(seed, height, depth, hardness, compliance, symmetric):
    gap = rough(seed, height, symmetric)
    approach = gap.min() + depth
    force, stiffness, status, pressure, _ = solved(gap, hardness, approach, compliance, mirrored=symmetric)
    if status == AT_BORDER:
        return
    assert status == CONVERGED
    assert stiffness >= 0
    assert_conditions(gap, hardness, approach, compliance, force, pressure)
    if symmetric:
        assert (pressure == pressure[:, ::-1]).all()


@pytest.mark.parametrize("seed", range(4))
def test_pressures_are_those_of_a_bounded_least_squares_problem(seed):
    """p.A p / 2 + p.(g - delta) is half of the square of U p - U^-T (delta - g), with A = U^T U."""
    gap = rough(seed, 3e-5)
    approach = gap.min() + 8e-5
    pressure = solved(gap, H, approach)[3]
    near = np.flatnonzero(gap.ravel() < approach)
    i, j = np.divmod(near, NY)
    unit = 1e9
    U = np.linalg.cholesky(unit * INFLUENCE[abs(i[:, None] - i), abs(j[:, None] - j)]).T
    right = scipy.linalg.solve_triangular(U, approach - gap.ravel()[near], trans="T")
    other = unit * scipy.optimize.lsq_linear(U, right, (0, H / unit), method="bvls", tol=1e-15).x
    assert (other == H).any()
    np.testing.assert_allclose(pressure.ravel()[near], other, atol=1e-7 * H)


def test_below_yield_nothing_changes_a_bit():
    none, bounded = law(), law(H)
    for wheel, tread, depth in ((0, 0, 1e-4), (0, 60, 2.5e-4), (1, 0, 5e-5), (1, 1000, 3e-4)):
        approach = total_separation(none, wheel, tread, 0).min() + depth
        one, two = (solve_patch(each, wheel, tread, 0, approach, 1e-10) for each in (none, bounded))
        assert one.pressure.max() < H
        assert (one.force, one.stiffness) == (two.force, two.stiffness)
        assert (one.pressure == two.pressure).all()


def test_force_of_full_plasticity_is_hardness_times_area():
    gap = rough(0, 0.0)
    force, _, status, pressure, in_contact = solved(gap, 1e7, 6e-5)
    assert status == CONVERGED
    assert force == pytest.approx(1e7 * AREA * in_contact.sum(), rel=0.03)
    assert force <= 1e7 * AREA * in_contact.sum()
    # Hardly any elastic displacement is left: wheel and rail touch where they would overlap.
    overlap = gap < 6e-5
    assert (in_contact <= overlap).all()
    assert in_contact.sum() > 0.97 * overlap.sum()
    assert pressure.max() == 1e7


@settings(deadline=None, max_examples=40)
@given(st.integers(-60, 60), st.integers(0, 1), st.floats(1e-6, 2.5e-4), st.floats(1e-9, 5e-5), st.floats(1e9, 6e9))
def test_force_rises_with_approach_and_hardness(tread, wheel, depth, more, hardness):
    bounded = law()._replace(hardness=hardness)
    approach = total_separation(bounded, wheel, tread, 0).min() + depth
    patch = solve_patch(bounded, wheel, tread, 0, approach)
    deeper = solve_patch(bounded, wheel, tread, 0, approach + more)
    harder = solve_patch(bounded._replace(hardness=1.1 * hardness), wheel, tread, 0, approach)
    elastic = solve_patch(law(), wheel, tread, 0, approach)
    rounding = 1e-9 * elastic.force
    assert deeper.force >= patch.force - rounding
    assert patch.force <= harder.force + rounding <= elastic.force + 2 * rounding
    assert patch.force <= hardness * AREA * (patch.pressure > 0).sum() + rounding
    assert ((elastic.pressure > 0) <= (patch.pressure > 0)).all()
    assert (deeper.pressure >= patch.pressure - 1e-9 * hardness).all()


def test_stiffness_is_the_derivative_of_the_force():
    bounded, step = law(H), 1e-8
    for tread in (-27, 25, 29):
        for compliance in (0.0, 2e-10):
            approach = total_separation(bounded, 0, tread, 0).min() + 1.5e-4
            below, at, above = (solve_patch(bounded, 0, tread, 0, approach + k * step, compliance) for k in (-1, 0, 1))
            assert at.share_at_hardness > 0.1
            assert (above.force - below.force) / (2 * step) == pytest.approx(at.stiffness, rel=0.02)


@settings(deadline=None, max_examples=30)
@given(st.integers(20, 34), st.floats(2e-5, 2e-4), st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_the_first_guess_does_not_change_a_bit(tread, depth, seed, share):
    bounded = law(H)
    gap = total_separation(bounded, 0, tread, 0)
    guess = np.random.default_rng(seed).random(gap.shape) < share
    pressures = np.empty((2, *gap.shape))
    found = []
    for start, pressure in zip((guess, np.zeros(gap.shape, bool)), pressures, strict=True):
        result = solve_bounded(bounded, 0, tread, 0, gap.min() + depth, 1e-10, start, pressure)
        found.append((result, start.tobytes()))
    assert found[0] == found[1]
    assert (pressures[0] == pressures[1]).all()


def test_symmetry_is_a_shortcut_only():
    bounded = law(H)
    whole = bounded._replace(tread_mirrored=np.zeros_like(bounded.tread_mirrored))
    assert bounded.tread_mirrored[0, 27]
    approach = total_separation(bounded, 0, 27, 0).min() + 1.5e-4
    half, full = (solve_patch(each, 0, 27, 0, approach) for each in (bounded, whole))
    assert half.share_at_hardness > 0.1
    np.testing.assert_allclose(half.pressure, full.pressure, atol=1e-9 * H)
    assert half.force == pytest.approx(full.force, rel=1e-11)


def test_mirrored_flats_give_mirrored_pressure():
    bounded = law(H)
    approach = total_separation(bounded, 0, 27, 0).min() + 1.5e-4
    ahead, behind = (solve_patch(bounded, 0, tread, 0, approach).pressure for tread in (27, -27))
    np.testing.assert_allclose(ahead, behind[::-1], atol=1e-9 * H)


def test_tables_end_where_the_first_element_yields():
    gap = rough(3, 1e-5)
    whole = force_path(gap, False, INFLUENCE, AREA, 5e4)
    path = force_path(gap, False, INFLUENCE, AREA, 5e4, H)
    assert (path[:-1] == whole[: len(path) - 1]).all()
    assert path[-1, 1] == pytest.approx(np.interp(path[-1, 0], *whole.T), rel=1e-12)
    pressure = solved(gap, np.inf, path[-1, 0])[3]
    assert pressure.max() == pytest.approx(H, rel=1e-9)


def test_force_goes_on_from_tables_to_solutions():
    solving, tabulated = short_flat(1.5e9, False), short_flat(1.5e9, True)
    touch = total_separation(solving, 0, 8, 0).min()
    for compliance in (0.0, 3e-10):
        for depth in np.linspace(-1e-5, 2e-4, 15):
            one, two = (contact_force(each, 0, 8, 0, touch + depth, compliance) for each in (solving, tabulated))
            assert one == pytest.approx(two, rel=1e-9, abs=1e-6)
    assert np.isnan(tabulated_force(tabulated, 0, 8, 0, touch + 2e-4, 0.0))


def test_without_yield_tables_are_those_of_an_elastic_contact():
    smooth = [
        build_contact_law([], ContactGeometry(), DX, 2713, largest_force=3e5, hardness=each) for each in (np.inf, H)
    ]
    assert (smooth[0].points == smooth[1].points).all()


@pytest.mark.parametrize("tables", [False, True])
def test_approach_for_a_force_of_a_contact_that_yields(tables):
    bounded = short_flat(1.5e9, tables)
    for tread in (-8, 5, 8, 1000):
        for force in (1e3, 40e3, 150e3):
            approach = approach_for_force(bounded, 0, tread, 0, force, 1e-10)
            assert force_at(bounded, 0, tread, 0, approach, 1e-10) == pytest.approx(force, rel=1e-9)
    assert approach_for_force(bounded, 0, 8, 0, 150e3) > approach_for_force(short_flat(np.inf, False), 0, 8, 0, 150e3)


def test_a_force_beyond_what_yields_within_the_area_is_an_error():
    soft = law()._replace(hardness=1e8)
    with pytest.raises(ContactError, match="cannot carry 400000 N"):
        approach_for_force(soft, 0, 28, 0, 400e3)
