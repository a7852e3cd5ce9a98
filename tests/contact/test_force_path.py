import numpy as np
import pytest

from wheelset_track_sim.contact.active_set_kernels import CONVERGED, solve_active_set
from wheelset_track_sim.contact.influence import influence_table
from wheelset_track_sim.contact.tables import force_path

NONE = np.empty((0, 0))


def solved(separation, mirrored, influence, area, approach):
    guess = np.zeros(separation.shape, bool)
    force, stiffness, status = solve_active_set(separation, mirrored, influence, area, approach, 0.0, guess, NONE)
    assert status == CONVERGED
    return force, stiffness, guess


@pytest.mark.parametrize("mirrored", [False, True])
def test_follows_an_element_that_leaves_the_contact(mirrored):
    # Neighbours coupled so strongly that the outer two unload the middle one: it enters first, and leaves again.
    influence = np.zeros((3, 5))
    influence[0, :3] = 1.0, 0.7, 0.3
    separation = np.full((3, 5), np.inf)
    separation[1, 1:4] = 0.1, 0.0, 0.1
    path = force_path(separation, mirrored, influence, 1.0, 5.0)
    approaches = np.linspace(0.001, path[-1, 0], 400)
    forces, _, sets = zip(*(solved(separation, mirrored, influence, 1.0, each) for each in approaches), strict=True)
    middle = [bool(each[1, 2]) for each in sets]
    assert middle[0]
    assert not middle[-1]
    np.testing.assert_allclose(np.interp(approaches, *path.T), forces, atol=1e-10)
    assert path[-1, 1] == pytest.approx(5.0, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_rough_surface_with_many_patches(seed):
    random = np.random.default_rng(seed)
    nx, ny, dx, dy = 33, 35, 1e-3, 0.6e-3
    x, y = (np.arange(nx) - nx // 2) * dx, (np.arange(ny) - ny // 2) * dy
    separation = x[:, None] ** 2 / 0.8 + y**2 / 0.5 + 2e-5 * random.standard_normal((nx, ny))
    influence = influence_table(nx, ny, dx, dy, 210e9, 0.3)
    path = force_path(separation, False, influence, dx * dy, 50e3)
    assert path[0].tolist() == [separation.min(), 0.0]
    assert path[-1, 1] == pytest.approx(50e3, rel=1e-12)
    slope = np.diff(path[:, 1]) / np.diff(path[:, 0])
    assert (np.diff(slope) > -1e-6 * slope[1:]).all()
    for share in random.random(25):
        approach = path[0, 0] + share * (path[-1, 0] - path[0, 0])
        force, _, _ = solved(separation, False, influence, dx * dy, approach)
        assert np.interp(approach, *path.T) == pytest.approx(force, abs=1e-6)


def test_ends_where_the_contact_reaches_the_border():
    influence = influence_table(5, 5, 1e-3, 1e-3, 210e9, 0.3)
    bowl = (np.arange(5) - 2.0) ** 2
    path = force_path(1e-6 * (bowl[:, None] + bowl), False, influence, 1e-6, 1e9)
    assert path[-1, 1] < 1e5
    assert (np.diff(path, axis=0) > 0).all()
