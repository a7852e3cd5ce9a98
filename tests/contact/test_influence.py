import numpy as np
import pytest
import scipy

from wheelset_track_sim.contact.influence import contact_modulus, influence, influence_table

DX, DY, E, NU = 1e-3, 0.7e-3, 210e9, 0.3


def test_is_the_integral_of_the_point_load():
    unit = 1 / (np.pi * contact_modulus(E, NU))
    for x, y in ((2e-3, 0.0), (1e-3, -1.4e-3), (0.0, 3.5e-3)):
        integral = scipy.integrate.dblquad(
            lambda v, u, x=x, y=y: 1 / np.hypot(x - u, y - v), -DX / 2, DX / 2, -DY / 2, DY / 2, epsrel=1e-10
        )[0]
        assert influence(x, y, DX, DY, E, NU) == pytest.approx(unit * integral, rel=1e-9)


def test_square_has_the_textbook_value_in_its_middle():
    # Johnson (1985), Section 3.3: uniform pressure on a square of side 2a sinks its middle by
    # 8 ln(1 + sqrt 2) p a/(pi E*).
    value = influence(0.0, 0.0, DX, DX, E, NU)
    assert value == pytest.approx(8 * np.log(1 + np.sqrt(2)) * (DX / 2) / (np.pi * contact_modulus(E, NU)), rel=1e-12)


def test_table_is_a_point_load_far_away_and_positive_definite():
    table = influence_table(60, 50, DX, DY, E, NU)
    far = DX * DY / (np.pi * contact_modulus(E, NU) * np.hypot(50 * DX, 40 * DY))
    assert table[50, 40] == pytest.approx(far, rel=1e-4)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(12), np.arange(9), indexing="ij"))
    K = table[abs(i[:, None] - i), abs(j[:, None] - j)]
    assert np.linalg.eigvalsh(K).min() > 0


@pytest.mark.parametrize(("dx", "dy"), [(1e-3, 0.75e-3), (1e-3, 1e-3), (1e-4, 5e-3), (5e-3, 1e-4)])
def test_the_inverse_has_the_signs_on_which_the_contact_solvers_rely(dx, dy):
    """No positive entry off the diagonal, and positive row sums; then the same holds for every set of the elements."""
    i, j = (index.ravel() for index in np.indices((32, 28)))
    table = influence_table(32, 28, dx, dy, E, NU)
    inverse = np.linalg.inv(table[abs(i[:, None] - i), abs(j[:, None] - j)])
    assert (table > 0).all()
    assert inverse[~np.eye(len(i), dtype=bool)].max() < 0
    assert inverse.sum(axis=1).min() > 1e-3 * inverse.max()
