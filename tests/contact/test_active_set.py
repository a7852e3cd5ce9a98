from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.contact_conditions import assert_contact_conditions
from wheelset_track_sim.contact import ContactGeometry, build_contact_law, solve_patch
from wheelset_track_sim.contact.active_set_kernels import candidates, cholesky, exchange, solve_active_set, solve_set
from wheelset_track_sim.contact.law_kernels import total_separation
from wheelset_track_sim.errors import ContactError
from wheelset_track_sim.irregularities import Breakout

DX, N_C = 0.001, 2713
DEFECTS = (
    Breakout("wheel_1", a=0.030, b=0.024, h=0.002),
    Breakout("wheel_2", a=0.020, b=0.010, h=0.0006, y=0.004),
)


@pytest.fixture(scope="module")
def law():
    return build_contact_law(DEFECTS, ContactGeometry(), DX, N_C, tables=False)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 17, 90])
def test_cholesky_factors(n):
    K = 1 / (1 + abs(np.subtract.outer(np.arange(n), np.arange(n)))) + np.eye(n)
    U = K.copy()
    assert cholesky(U)
    np.testing.assert_allclose(np.triu(U).T @ np.triu(U), K, atol=1e-13)


def test_cholesky_refuses_an_indefinite_matrix():
    assert not cholesky(np.array([[1.0, 2.0], [2.0, 1.0]]))
    assert not cholesky(np.array([[np.nan]]))


@pytest.mark.parametrize(("wheel", "tread"), [(0, 0), (0, 21), (0, -30), (0, 1000), (1, 0), (1, 15)])
@pytest.mark.parametrize("compliance", [0.0, 2e-10])
def test_contact_conditions_hold_on_every_element(law, wheel, tread, compliance):
    gap = total_separation(law, wheel, tread, 0)
    patch = solve_patch(law, wheel, tread, 0, gap.min() + 2.5e-4, compliance)
    assert_contact_conditions(law, gap, patch, compliance)


@pytest.mark.parametrize(("wheel", "tread"), [(0, 0), (0, 21), (1, 3), (0, 1000)])
def test_stiffness_is_the_derivative_of_the_force(law, wheel, tread):
    touch = total_separation(law, wheel, tread, 0).min()
    for compliance in (0.0, 2e-10):
        for depth in (5e-6, 6e-5, 2.1e-4):
            step = 1e-3 * depth
            below, at, above = (
                solve_patch(law, wheel, tread, 0, touch + depth + k * step, compliance) for k in (-1, 0, 1)
            )
            # The force is piecewise linear: one-sided differences bracket the slope.
            left, right = (at.force - below.force) / step, (above.force - at.force) / step
            assert left * (1 - 1e-9) <= at.stiffness <= right * (1 + 1e-9)
            assert left == pytest.approx(right, rel=0.02)


@settings(deadline=None, max_examples=60)
@given(st.integers(-60, 60), st.integers(0, 1), st.floats(-1e-5, 3.5e-4), st.floats(1e-9, 1e-4))
def test_force_rises_and_stiffness_never_falls(law, tread, wheel, depth, more):
    touch = total_separation(law, wheel, tread, 0).min()
    first = solve_patch(law, wheel, tread, 0, touch + depth)
    second = solve_patch(law, wheel, tread, 0, touch + depth + more)
    assert first.force >= 0
    assert (first.force == 0) == (touch + depth <= touch)
    assert second.force > first.force or touch + depth + more <= touch
    # The contact only grows: the force is convex, and the tangent at the shallower point lies below.
    assert second.stiffness >= first.stiffness * (1 - 1e-9)
    assert second.force >= first.force + first.stiffness * more * (1 - 1e-9)


@settings(deadline=None, max_examples=40)
@given(st.integers(-60, 60), st.floats(1e-6, 3.5e-4), st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_the_first_guess_does_not_change_a_bit(law, tread, depth, seed, share):
    gap = total_separation(law, 0, tread, 0)
    approach = gap.min() + depth
    none = np.empty((0, 0))
    guess = np.random.default_rng(seed).random(gap.shape) < share
    cold = np.zeros(gap.shape, bool)
    from_guess = solve_active_set(gap, True, law.influence, law.element_area, approach, 0.0, guess, none)
    from_nothing = solve_active_set(gap, True, law.influence, law.element_area, approach, 0.0, cold, none)
    assert from_guess == from_nothing
    assert (guess == cold).all()


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("compliance", [0.0, 2e-10])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_after_the_first_exchange_elements_only_leave(law, mirrored, compliance, share):
    """The proof of termination, step by step: distances never fall, so no set comes again."""
    gap = total_separation(law, 0, 20, 0)
    approach, centre = gap.min() + 2e-4, gap.shape[1] // 2
    c = candidates(gap, mirrored, approach)
    full = law.influence[abs(c.i[:, None] - c.i), abs(c.j[:, None] - c.j)]
    image = law.influence[abs(c.i[:, None] - c.i), c.j[:, None] + c.j - 2 * centre] if mirrored else full
    active = np.random.default_rng(3).random(len(c.gap)) < share
    active[c.gap.argmin()] = True
    sets, distances = [], []
    while True:
        chosen = np.nonzero(active)[0]
        p = np.empty(len(chosen))
        of_law = law.influence, law.element_area, approach, compliance
        force, _, definite = solve_set(c, chosen, mirrored, centre, *of_law, p)
        assert definite
        local = approach - compliance * force
        sets.append(set(chosen))
        distances.append(c.gap + 0.5 * (full + image)[:, chosen] @ (c.weight[chosen] * p) - local)
        if exchange(c, chosen, p, mirrored, centre, law.influence, local, 1e-15, True, active) == 0:
            break
    assert len(sets) > 2
    assert len(sets) <= 10
    assert all(after < before for before, after in pairwise(sets[1:]))
    assert np.diff(distances, axis=0).min() > -1e-14
    assert distances[-1].min() > -1e-14


@pytest.mark.parametrize("tread", [0, 17, 1000])
def test_symmetry_is_a_shortcut_only(law, tread):
    whole = law._replace(tread_mirrored=np.zeros_like(law.tread_mirrored))
    approach = total_separation(law, 0, tread, 0).min() + 2e-4
    half, full = (solve_patch(each, 0, tread, 0, approach) for each in (law, whole))
    assert law.tread_mirrored[0, tread]
    np.testing.assert_allclose(half.pressure, full.pressure, atol=1e-9 * full.pressure.max())
    assert half.force == pytest.approx(full.force, rel=1e-11)
    assert half.stiffness == pytest.approx(full.stiffness, rel=1e-9)


def test_mirrored_defects_give_mirrored_pressure():
    left, right = (
        build_contact_law([Breakout("wheel_1", 0.02, 0.012, 0.0005, y=y)], ContactGeometry(), DX, N_C, tables=False)
        for y in (0.005, -0.005)
    )
    a, b = (solve_patch(law, 0, 4, 0, 5e-4) for law in (left, right))
    assert a.force > 10e3
    assert not np.allclose(a.pressure, a.pressure[:, ::-1], rtol=1e-2)
    np.testing.assert_allclose(a.pressure, b.pressure[:, ::-1], atol=1e-9 * a.pressure.max())
    ahead = solve_patch(left, 0, -4, 0, 5e-4)
    np.testing.assert_allclose(a.pressure, ahead.pressure[::-1], atol=1e-9 * a.pressure.max())


def test_a_size_c_defect_is_bridged_at_its_ends(law):
    patch = solve_patch(law, 0, 0, 0, total_separation(law, 0, 0, 0).min() + 1.5e-4)
    along = patch.pressure.sum(axis=1) > 0
    assert not along[abs(law.x) < 0.010].any()
    assert along[law.x > 0.010].any()
    assert along[law.x < -0.010].any()


def test_no_contact_is_zero_force_without_a_solution(law):
    patch = solve_patch(law, 0, 1000, 0, 0.0)
    assert patch.force == patch.stiffness == 0.0
    assert not patch.pressure.any()
    assert solve_patch(law, 0, 0, 0, 2e-4).force == 0.0


@pytest.mark.parametrize("approach", [np.nan, np.inf, 0.02])
def test_what_cannot_be_solved_is_an_error_with_inputs(approach):
    law = build_contact_law([], ContactGeometry(), DX, N_C, tables=False)
    with pytest.raises(ContactError, match=rf"wheel_2 at tread step 7, rail step 3, approach {approach:g} m"):
        solve_patch(law, 1, 7, 3, approach)
