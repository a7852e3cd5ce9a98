"""Contacts of profiles against Hertz, the half-space solver of ContactMechanics, the arcs, and the plain active set."""

import numpy as np
import pytest

from support.half_space import half_space
from wheelset_track_sim.contact import (
    ContactGeometry,
    HertzContact,
    Points,
    ProfilePair,
    RailHead,
    Straight,
    approach_for_force,
    build_contact_law,
    contact_force,
    solve_patch,
)
from wheelset_track_sim.contact.law_kernels import solve_contact, tabulated_force, total_separation
from wheelset_track_sim.irregularities import Breakout, Roughness
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.wheelset.kinds import load_wheelset

pytestmark = pytest.mark.slow

DX, N_C = 1e-3, 2713
X40 = load_wheelset("x40")
DEFECTS = (Breakout("wheel_1", 0.005, 0.004, 0.0002, y=-0.008), Breakout("wheel_2", 0.004, 0.004, 0.0001, y=-0.008))


def law_of(geometry, irregularities=(), tables=False):
    return build_contact_law(irregularities, geometry, DX, N_C, tables=tables)


@pytest.fixture(scope="module", autouse=True)
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path_factory.mktemp("models")))
        yield


@pytest.fixture(scope="module", params=["lateral_offset", "worn_profiles"])
def geometry(request):
    return load_scenario(request.param).geometry


@pytest.mark.parametrize("wheel_crown", [0.5, -0.6])
def test_crowned_wheel_on_crowned_rail_is_hertz(wheel_crown):
    """Elliptic contacts in closed form: a convex tread and a hollow one, on R300."""
    y = np.arange(-160, 161) * 2.5e-4
    tread = Points(y, -np.sign(wheel_crown) * (abs(wheel_crown) - np.sqrt(wheel_crown**2 - y**2)), noisy=False)
    law = law_of(ContactGeometry(pairs=(ProfilePair(tread, RailHead((0.3,), (0.036,))),) * 2))
    theory = HertzContact(0.43175, 1 / (1 / 0.3 + 1 / wheel_crown), ContactGeometry().contact_modulus)
    for force in (50e3, 98.1e3, 200e3):
        patch = solve_patch(law, 0, 0, 0, theory.approach(force))
        assert patch.force == pytest.approx(force, rel=3e-3)
        assert patch.pressure.max() == pytest.approx(theory.peak_pressure(force), rel=0.01)


def test_cone_on_a_round_rail_is_hertz_beside_the_middle():
    law = law_of(ContactGeometry(pairs=(ProfilePair(Straight(1 / 40), RailHead((0.3,), (0.036,))),) * 2))
    inside = 0.3 * np.sin(np.arctan(1 / 40))
    for wheel, at in ((0, inside), (1, -inside)):
        radius = 0.43175 + inside / 40
        theory = HertzContact(radius, 0.3, ContactGeometry().contact_modulus)
        patch = solve_patch(law, wheel, 0, 0, theory.approach(98.1e3))
        assert patch.force == pytest.approx(98.1e3, rel=4e-3)
        across = patch.pressure.sum(axis=0)
        assert (across @ patch.y) / across.sum() == pytest.approx(at, abs=5e-5)


def test_points_of_60e1_bear_as_its_arcs_do():
    arcs = load_scenario("lateral_offset")
    points = load_scenario("lateral_offset", ["profiles.rail_1=head_60e1_points", "profiles.rail_2=head_60e1_points"])
    exact, sampled = (law_of(scenario.geometry) for scenario in (arcs, points))
    for wheel in (0, 1):
        for force in (30e3, 98.1e3, 300e3):
            approach = approach_for_force(exact, wheel, 0, 0, force)
            assert contact_force(sampled, wheel, 0, 0, approach, 0.0) == pytest.approx(force, rel=5e-3)


@pytest.mark.parametrize("depth", [1e-4, 2e-4])
def test_pressure_agrees_with_another_half_space_solver(geometry, depth):
    law = law_of(geometry, DEFECTS)
    for wheel in (0, 1):
        for tread in (0, 4, 1000):
            gap = total_separation(law, wheel, tread, 0)
            approach = gap.min() + depth
            patch = solve_patch(law, wheel, tread, 0, approach)
            # Its first guess is what lies below zero, and from one element alone it does not find out.
            other, its_approach = half_space(gap - gap.min(), geometry.contact_modulus, patch.force)
            assert patch.force > 10e3
            assert np.abs(patch.pressure - other).max() < 1e-6 * other.max()
            assert its_approach == pytest.approx(depth, rel=1e-7)


def test_solvers_in_order_and_with_tables_are_the_plain_active_set(geometry):
    bare, tables = law_of(geometry, DEFECTS), law_of(geometry, DEFECTS, tables=True)
    assert (tables.table >= 0).all()
    assert not tables.tread_mirrored.any()
    none = np.empty((0, 0))
    for law in (bare, law_of(geometry, [Roughness("wheel_1"), Roughness("wheel_2", seed=1)])):
        plain = law._replace(nested=tuple(each._replace(beyond=np.full(1, -np.inf)) for each in law.nested))
        for wheel in (0, 1):
            for tread, approach in ((0, 2e-4), (5, 1.5e-4), (1000, 1.2e-4), (1000, 2.2e-4)):
                guess = np.zeros(law.separation.shape[1:], bool)
                found = solve_contact(law, wheel, tread, 0, approach, 1e-10, guess.copy(), none)
                expected = solve_contact(plain, wheel, tread, 0, approach, 1e-10, guess.copy(), none)
                assert found[0] == pytest.approx(expected[0], rel=1e-9)
                assert found[2] == expected[2] == 0
                if law is bare:
                    by_table = tabulated_force(tables, wheel, tread, 0, approach, 1e-10)
                    assert by_table == pytest.approx(found[0], rel=1e-9)
