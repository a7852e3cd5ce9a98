import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.contact_conditions import assert_contact_conditions
from wheelset_track_sim.contact import (
    ContactGeometry,
    ProfilePair,
    RailHead,
    approach_for_force,
    build_contact_law,
    solve_patch,
)
from wheelset_track_sim.contact.active_set_kernels import CONVERGED, solve_active_set
from wheelset_track_sim.contact.law_kernels import solve_contact, solve_nested, total_separation
from wheelset_track_sim.contact.ordered.nested import nested_contacts
from wheelset_track_sim.contact.ordered.nested_kernels import solve_in_order
from wheelset_track_sim.contact.ordered.order_kernels import FAR
from wheelset_track_sim.contact.ordered.panel_kernels import factored, inverted, multiply, multiply_transposed, row
from wheelset_track_sim.irregularities import Breakout, Roughness
from wheelset_track_sim.runtime.jit import kernel

DX, N_C, N_R = 0.001, 2713, 1200
NONE = np.empty((0, 0))


def rough_law(level, seed=0, defects=(), **options):
    seeds = {"wheel_1": 1, "wheel_2": 2, "rail_1": 11, "rail_2": 12}
    rough = [Roughness(on, seed=seed + number, level=level) for on, number in seeds.items()]
    return build_contact_law([*rough, *defects], ContactGeometry(), DX, N_C, rail_steps=N_R, tables=False, **options)


@pytest.fixture(scope="module", params=[-10.0, 0.0, 8.0], ids="{:+.0f} dB".format)
def law(request):
    return rough_law(request.param)


@pytest.fixture(scope="module")
def smooth():
    return build_contact_law([], ContactGeometry(), DX, N_C, tables=False)


def plainly(law, step, approach, compliance, wheel=0):
    guess = np.zeros(law.separation.shape[1:], bool)
    pressure = np.empty(law.separation.shape[1:])
    gap = total_separation(law, wheel, step, step)
    found = solve_active_set(gap, False, law.influence, law.element_area, approach, compliance, guess, pressure)
    return (*found, guess, pressure)


def in_order(law, step, approach, compliance, guess=None, wheel=0):
    guess = np.zeros(law.separation.shape[1:], bool) if guess is None else guess.copy()
    pressure = np.empty(law.separation.shape[1:])
    return (*solve_nested(law, wheel, step, step, approach, compliance, guess, pressure), guess, pressure)


steps, depths = st.integers(-5000, 5000), st.floats(1e-7, 2.2e-4)
compliances = st.sampled_from([0.0, 1.5e-10, 1e-9])


@settings(max_examples=80)
@given(steps, depths, compliances, st.integers(0, 1))
@pytest.mark.slow
def test_is_the_plain_active_set(law, step, depth, compliance, wheel):
    approach = total_separation(law, wheel, step, step).min() + depth
    force, stiffness, status, elements, pressure = in_order(law, step, approach, compliance, wheel=wheel)
    if status == FAR:
        return
    expected = plainly(law, step, approach, compliance, wheel)
    assert status == expected[2] == CONVERGED
    assert force == pytest.approx(expected[0], rel=1e-11)
    assert stiffness == pytest.approx(expected[1], rel=1e-10)
    assert (elements == expected[3]).all()
    np.testing.assert_allclose(pressure, expected[4], atol=1e-10 * expected[4].max())


def test_hardly_any_contact_is_far_from_smooth(law):
    # The method is there for such roughness: leaving it to the plain active set would pass every other test.
    depth = [(step, depth) for step in range(0, 3000, 37) for depth in (2e-5, 9e-5, 1.8e-4)]
    far = [
        in_order(law, step, total_separation(law, 0, step, step).min() + depth, 1e-10)[2] == FAR
        for step, depth in depth
    ]
    assert np.mean(far) < 0.02


@settings(max_examples=40)
@given(steps, depths, compliances)
def test_conditions_hold_on_every_element(law, step, depth, compliance):
    gap = total_separation(law, 0, step, step)
    patch = solve_patch(law, 0, step, step, gap.min() + depth, compliance)
    assert_contact_conditions(law, gap, patch, compliance)


@settings(max_examples=60)
@given(steps, depths, compliances, st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_the_first_guess_does_not_change_a_bit(law, step, depth, compliance, seed, share):
    approach = total_separation(law, 0, step, step).min() + depth
    guess = np.random.default_rng(seed).random(law.separation.shape[1:]) < share**4
    near = in_order(law, step - 1, approach, compliance)[3]
    for one in (guess, near, near & ~guess):
        cold, warm = in_order(law, step, approach, compliance), in_order(law, step, approach, compliance, one)
        assert cold[2] == warm[2]
        if cold[2] != FAR:
            assert cold[:2] == warm[:2]
            assert (cold[3] == warm[3]).all()


@settings(max_examples=30)
@given(steps, st.floats(0, 1e-4))
def test_loss_of_contact_is_exact(law, step, height):
    touch = total_separation(law, 0, step, step).min()
    assert in_order(law, step, touch - height, 1e-10)[:3] == (0.0, 0.0, CONVERGED)
    assert 0.0 < in_order(law, step, touch + 1e-12, 1e-10)[0] < 0.1


@pytest.mark.parametrize("force", [1.0, 1e3, 98.1e3, 400e3])
def test_approach_for_force_on_rough_surfaces(law, force):
    approach = approach_for_force(law, 0, 70, 40, force, 1e-10)
    assert solve_patch(law, 0, 70, 40, approach, 1e-10).force == pytest.approx(force, rel=1e-9)


@settings(max_examples=40)
@given(st.floats(1e-7, 2.4e-4), compliances)
def test_smooth_surfaces_and_symmetric_pressure(smooth, depth, compliance):
    force, stiffness, status, elements, pressure = in_order(smooth, 5, depth, compliance)
    expected = plainly(smooth, 5, depth, compliance)
    assert status == CONVERGED
    assert force == pytest.approx(expected[0], rel=1e-11)
    assert stiffness == pytest.approx(expected[1], rel=1e-10)
    for mirrored in (pressure[:, ::-1], pressure[::-1]):
        np.testing.assert_allclose(pressure, mirrored, atol=1e-10 * pressure.max())
    assert (elements == elements[:, ::-1]).all()
    assert (elements == elements[::-1]).all()


def test_roughness_of_no_height_changes_no_bit(smooth):
    none = rough_law(-60.0)
    none = none._replace(
        tread=0 * none.tread, rail=0 * none.rail, tread_top=0 * none.tread_top, rail_top=0 * none.rail_top
    )
    assert none.separation.shape == smooth.separation.shape
    for depth in (1e-6, 9e-5, 2e-4):
        assert in_order(none, 3, depth, 1e-10)[:3] == in_order(smooth, 3, depth, 1e-10)[:3]


def test_a_pit_in_the_middle_and_a_defect(smooth):
    # An element far before the edge is out of order; a breakout is no contact for the method, and solved all the same.
    for defect, far in (
        (Breakout("wheel_1", 0.002, 0.002, 1e-4), False),
        (Breakout("wheel_1", 0.03, 0.024, 2e-3), True),
    ):
        law = build_contact_law([defect], ContactGeometry(), DX, N_C, tables=False)
        approach = total_separation(law, 0, 0, 0).min() + 1.1e-4
        expected = plainly(law, 0, approach, 0.0)
        assert (in_order(law, 0, approach, 0.0)[2] == FAR) == far
        found = solve_contact(law, 0, 0, 0, approach, 0.0, np.zeros(law.separation.shape[1:], bool), NONE)
        assert found[:2] == pytest.approx(expected[:2], rel=1e-9)
        assert not expected[3][len(law.x) // 2, len(law.y) // 2]


@pytest.mark.parametrize("approach", [np.nan, np.inf, 0.1, 1e-3])
def test_what_is_too_deep_or_no_number_is_not_for_the_method(law, approach):
    guess = np.ones(law.separation.shape[1:], bool)
    assert solve_nested(law, 0, 0, 0, approach, 0.0, guess, NONE)[2] == FAR
    assert guess.all()
    assert solve_nested(law, 0, 0, 0, 1e-4, np.nan, guess, NONE)[2] == FAR


@kernel
def passage(law, first, approach, forces):
    for step in range(first, first + len(forces)):
        for wheel in range(2):
            forces[step - first, wheel] = solve_contact(
                law, wheel, step, step, approach[step % len(approach)], 1e-10, law.in_contact[wheel], np.empty((0, 0))
            )[0]


def test_chunks_do_not_change_a_bit(law):
    approach = 1.1e-4 + 1.5e-4 * np.sin(0.02 * np.arange(700))

    def run(chunk):
        mine = law._replace(in_contact=np.zeros_like(law.in_contact))
        forces = np.full((700, 2), np.nan)
        for first in range(0, 700, chunk):
            passage(mine, first, approach, forces[first : first + chunk])
        return forces

    whole = run(700)
    assert np.isfinite(whole).all()
    assert (whole == 0).any()
    assert whole.max() > 200e3
    for chunk in (1, 32, 137):
        assert (run(chunk) == whole).all()


@pytest.mark.slow
def test_nothing_adds_up_over_a_long_run(law):
    """After 1e5 steps a solution has the bits of one that begins there."""
    approach = 1.1e-4 + 3e-5 * np.sin(0.02 * np.arange(50_000))
    forces = np.empty((50_000, 2))
    passage(law, 0, approach, forces)
    assert np.isfinite(forces).all()
    fresh = law._replace(in_contact=np.zeros_like(law.in_contact))
    again = np.empty((200, 2))
    passage(fresh, 49_800, approach, again)
    assert (again == forces[-200:]).all()
    for step in range(49_800, 50_000, 10):
        assert plainly(law, step, approach[step], 1e-10)[0] == pytest.approx(forces[step, 0], rel=1e-11)


@pytest.mark.parametrize("n", [16, 32, 96])
def test_leading_blocks_of_factor_and_inverse(n):
    K = 1 / (1 + abs(np.subtract.outer(np.arange(96), np.arange(96)))) + np.eye(96)
    L = factored(K)
    X = inverted(L, 64)
    dense = np.zeros((96, 96))
    for c in range(96):
        dense[c, : c + 1] = L[row(c) : row(c) + c + 1]
    np.testing.assert_allclose(dense, np.linalg.cholesky(K), atol=1e-14)
    np.testing.assert_allclose(dense[:n, :n] @ dense[:n, :n].T, K[:n, :n], atol=1e-14)
    b, found = np.random.default_rng(n).standard_normal(96), np.empty(96)
    multiply(L, 0, n, b, found)
    np.testing.assert_allclose(found[:n], dense[:n] @ b, atol=1e-13)
    if n <= 64:
        multiply(X, 0, n, b, found)
        np.testing.assert_allclose(dense[:n, :n] @ found[:n], b[:n], atol=1e-12)
        back = np.full(96, np.nan)
        multiply_transposed(X, n, b, 0, n, back)
        np.testing.assert_allclose(dense[:n, :n].T @ back[:n], b[:n], atol=1e-12)


def test_factor_of_a_matrix_that_has_none_is_no_number():
    assert np.isnan(factored(-np.eye(16))).any()


def test_order_is_that_of_contacts_which_grow(smooth):
    nested = smooth.nested[0]
    nx, ny = smooth.separation.shape[1:]
    place = np.full(nx * ny, len(nested.element))
    place[nested.element] = np.arange(len(nested.element))
    for force in (20e3, 98.1e3, 300e3):
        inside = solve_patch(smooth, 0, 0, 0, approach_for_force(smooth, 0, 0, 0, force)).pressure.ravel() > 0
        assert (place[inside] >= inside.sum()).sum() <= 0.04 * inside.sum() + 2
    assert (np.diff(nested.beyond) >= 0).all()
    left_out = np.setdiff1d(np.arange(nx * ny), nested.element)
    assert nested.beyond[-1] == smooth.separation[0].ravel()[left_out].min()
    assert not {0, nx - 1} & set(nested.element // ny)
    assert not {0, ny - 1} & set(nested.element % ny)


@pytest.mark.parametrize("m", [10, 250, 600])
def test_a_flat_punch_bears_on_all_of_its_elements(smooth, m):
    """More of them are close to the deepest one than under a round surface: the smooth contact must not exceed them."""
    nested = smooth.nested[0]
    i, j = np.divmod(nested.element[:m], smooth.separation.shape[2])
    A = smooth.influence[abs(i[:, None] - i), abs(j[:, None] - j)]
    elements, pressure = np.zeros(m, bool), np.empty(m)
    force, _, status = solve_in_order(nested, np.zeros(m), smooth.element_area, 1e-5, 0.0, elements, pressure)
    assert status == CONVERGED
    assert elements.all()
    np.testing.assert_allclose(pressure, np.linalg.solve(A, np.full(m, 1e-5)), rtol=1e-9)
    assert force == pytest.approx(pressure.sum() * smooth.element_area, rel=1e-12)


def test_pressures_act_at_least_as_at_their_mean_distance(smooth):
    nested = smooth.nested[0]
    dx, dy = (abs(np.subtract.outer(each, each)) for each in (nested.x, nested.y))
    step_x, step_y = smooth.x[1] - smooth.x[0], smooth.y[0, 1] - smooth.y[0, 0]
    influence = smooth.influence[np.round(dx / step_x).astype(int), np.round(dy / step_y).astype(int)]
    apart = dx + dy > 0
    assert (influence * np.hypot(dx, dy))[apart].min() >= nested.far * (1 - 1e-9) > 0


def test_other_geometries():
    sharp = ContactGeometry(wheel_radius=0.3, pairs=(ProfilePair(rail=RailHead((0.1,), (0.03,))),) * 2)
    law = build_contact_law([], sharp, DX, 2000, tables=False)
    assert (nested_contacts(sharp, 0, law.x, law.y[0], law.separation[0]).element == law.nested[0].element).all()
    for depth in (1e-5, 2e-4):
        assert in_order(law, 0, depth, 0.0)[0] == pytest.approx(plainly(law, 0, depth, 0.0)[0], rel=1e-11)
