import numpy as np
import pytest

from wheelset_track_sim.contact import ContactGeometry, ProfilePair, RailHead, approach_for_force, build_contact_law
from wheelset_track_sim.contact.law import ELEMENT_WIDTH
from wheelset_track_sim.contact.law_kernels import ContactLaw, solve_contact
from wheelset_track_sim.contact.ordered.hinge_kernels import FILTERED, filtered_force
from wheelset_track_sim.contact.ordered.nested import hinges_of, nested_contacts
from wheelset_track_sim.contact.ordered.order_kernels import FAR
from wheelset_track_sim.irregularities import Breakout, Roughness

DX, N_C, N_R = 0.001, 2713, 300
NONE = np.empty((0, 0))
LOAD = 98.1e3  # N


@pytest.fixture(scope="module")
def law():
    """A law whose heights the tests write; it has hinges."""
    smooth = build_contact_law([], ContactGeometry(), DX, N_C, rail_steps=N_R, tables=False)
    return with_hinges(smooth, ContactGeometry())


def with_hinges(law, geometry):
    nested = [nested_contacts(geometry, wheel, law.x, law.y[wheel] - geometry.touch(wheel), law.separation[wheel])
              for wheel in (0, 1)]  # fmt: skip
    nx, ny = law.separation.shape[1:]
    fall = np.stack(
        [geometry.separation(wheel, DX * np.arange(-nx, nx + 1), geometry.touch(wheel)) for wheel in (0, 1)]
    )
    hinges = hinges_of(nested, fall, ny, geometry.contact_modulus, DX, ELEMENT_WIDTH)
    return law._replace(nested=tuple(nested), hinges=hinges)


def with_tread(law: ContactLaw, heights) -> ContactLaw:
    """The same law with ``heights`` (n_c, ny) on wheel 1, m."""
    tread = law.tread.copy()
    tread[0] = heights
    return law._replace(tread=tread, tread_top=np.full_like(law.tread_top, np.max(heights)))


def rough(law, level=0.0, seed=1):
    field = Roughness("wheel_1", seed=seed, level=level).field(N_C, DX, law.y[0])
    return with_tread(law, field)


def filtered(law, step, approach, compliance=0.0, bound=1e9, wheel=0):
    surfaces = law.tread[wheel], law.rail_row[wheel], law.rail
    return filtered_force(
        law.hinges,
        wheel,
        law.separation.shape[1:],
        *surfaces,
        step,
        step,
        law.element_area,
        approach,
        compliance,
        bound,
    )


def solved(law, step, approach, compliance=0.0, wheel=0):
    guess = np.zeros(law.separation.shape[1:], bool)
    return solve_contact(law, wheel, step, step, approach, compliance, guess, NONE)[0]


@pytest.mark.parametrize("height", [0.0, 2e-4, -3e-5])
def test_a_constant_height_is_exact(law, height):
    level = with_tread(law, np.full((N_C, law.tread.shape[2]), height))
    for approach in (4e-5, 9.3e-5, 1.4e-4):
        force, estimate, status = filtered(level, 7, approach - height, 1e-10)
        assert status == FILTERED
        assert estimate < 0.5
        assert force == pytest.approx(solved(law, 7, approach, 1e-10), abs=0.5)


def test_the_term_of_second_order_is_right(law):
    """The mean of heights under a flat punch is exact to first order; nearly all that it misses is of second order."""
    surface, first, second = rough(law), [], []
    ny = law.tread.shape[2]
    for step in range(0, N_C, 40):
        approach = approach_for_force(law, 0, 0, 0, LOAD) - surface.tread[0, step, ny // 2]
        force, _, status = filtered(surface, step, approach)
        if status != FILTERED:
            continue
        place = law.hinges.opening.shape[2] + 31  # the mean over 248 elements, about as many as are in contact
        rows = np.arange(step - law.separation.shape[1] // 2, step + law.separation.shape[1] // 2 + 1) % N_C
        mean = law.hinges.weights[0, place] @ surface.tread[0, rows].ravel()[law.hinges.element[0]]
        exact = solved(surface, step, approach)
        first.append(solved(law, step, approach + mean) - exact)
        second.append(force - exact)
    assert len(first) > 50
    assert np.mean(first) < -100.0  # roughness bears more
    assert np.std(second) < 0.05 * np.std(first)
    assert abs(np.mean(second)) < 0.01 * abs(np.mean(first))


def test_the_force_is_that_of_the_approach_which_it_leaves(law):
    surface, compliance = rough(law), 2e-10
    for step in range(0, 500, 50):
        force, _, status = filtered(surface, step, 1.2e-4, compliance)
        assert status == FILTERED
        assert filtered(surface, step, 1.2e-4 - compliance * force)[0] == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize("elements", [-4, 1, 3])
def test_on_a_slope_the_contact_is_that_of_smooth_surfaces_further_ahead(law, elements):
    """Of a whole number of elements the slope leaves nothing; half an element more is within 0.004 %."""
    nx, x = len(law.x), DX * (np.arange(N_C) - 1000)
    radius = ContactGeometry().wheel_radius
    at_half = []
    for moved, accuracy in ((elements, 0.02), (elements + 0.5, 4.0)):
        surface = with_tread(law, np.where(abs(x) < nx * DX, moved * DX / radius * x, 0.0)[:, None])
        force, estimate, status = filtered(surface, 1000, 1e-4, 1e-10)
        assert status == FILTERED
        assert force == pytest.approx(solved(surface, 1000, 1e-4, 1e-10), abs=accuracy)
        at_half.append(estimate)
    assert at_half[0] < 1.0 < at_half[1] < 50.0


def test_positions_may_be_of_any_size(law):
    surface = rough(law)
    found = filtered(surface, 5, 1e-4, 1e-10)
    assert found[2] == FILTERED
    assert filtered(surface, 5 - 3 * N_C * N_R, 1e-4, 1e-10) == found


def test_a_decision_does_not_depend_on_what_was_before(law):
    surface = rough(law, 6.0)
    steps = range(0, 600, 7)
    forward = [filtered(surface, step, 1e-4, 1e-10, 100.0) for step in steps]
    backward = [filtered(surface, step, 1e-4, 1e-10, 100.0) for step in reversed(steps)][::-1]
    assert repr(forward) == repr(backward)
    assert {found[2] for found in forward} == {FILTERED, FAR}


@pytest.mark.parametrize("approach", [-1e-4, 0.0, 1e-6, 1e-5, 1.0, np.inf, np.nan])
def test_small_lost_and_huge_contacts_are_left_to_the_solver(law, approach):
    assert filtered(rough(law), 3, approach)[2] == FAR


def test_what_is_estimated_above_the_bound_is_left_to_the_solver(law):
    surface = rough(law)
    _, estimate, status = filtered(surface, 9, 1e-4)
    assert status == FILTERED
    assert estimate > 0.0
    assert filtered(surface, 9, 1e-4, bound=0.99 * estimate)[2] == FAR


@pytest.mark.parametrize(("a", "depth"), [(0.004, 4e-5), (0.002, 6e-5), (0.003, 1e-3)])
def test_a_dip_in_the_middle_is_left_to_the_solver(law, a, depth):
    """No hinge near the edge notices it, but the pressure within it is gone."""
    pit = Breakout("wheel_1", a, a, depth, angle=2 * np.pi * 1000 / N_C)
    dipped = build_contact_law([pit], ContactGeometry(), DX, N_C, rail_steps=N_R, tables=False)
    ny = dipped.tread.shape[2] // 2 - law.tread.shape[2] // 2
    heights = (
        dipped.tread[0][:, ny : dipped.tread.shape[2] - ny]
        if ny >= 0
        else np.pad(dipped.tread[0], [(0, 0), (-ny, -ny)])
    )
    surface = with_tread(law, heights)
    assert filtered(surface, 1000, 1e-4)[2] == FAR
    assert filtered(surface, 1100, 1e-4)[2] == FILTERED


def test_wheels_on_different_profiles_have_hinges_of_their_own():
    geometry = ContactGeometry(pairs=(ProfilePair(), ProfilePair(rail=RailHead(radii=(0.35, 0.09, 0.013)))))
    smooth = build_contact_law([], geometry, DX, N_C, rail_steps=N_R, tables=False)
    different = with_hinges(smooth, geometry)
    for wheel in (0, 1):
        force, _, status = filtered(different, 0, 1e-4, wheel=wheel)
        assert status == FILTERED
        assert force == pytest.approx(solved(different, 0, 1e-4, wheel=wheel), abs=2.0)
    assert abs(filtered(different, 0, 1e-4)[0] - filtered(different, 0, 1e-4, wheel=1)[0]) > 1e3
