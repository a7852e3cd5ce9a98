import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from wheelset_track_sim.samples.principal import maximum_principal, principal

# LAPACK, which is asked here, loses half of its digits beside components whose squares underflow.
COMPONENTS = st.floats(-1e9, 1e9).map(lambda value: value if abs(value) > 1e-9 else 0.0)


@given(arrays(np.float64, (5, 6), elements=COMPONENTS))
def test_principal_stresses_are_the_eigenvalues(stress: np.ndarray) -> None:
    xx, yy, zz, xy, xz, yz = stress.T
    tensors = np.stack([np.stack([xx, xy, xz]), np.stack([xy, yy, yz]), np.stack([xz, yz, zz])]).transpose(2, 0, 1)
    expected = np.linalg.eigvalsh(tensors)[:, ::-1]
    scale = np.abs(stress).max(axis=1, keepdims=True)
    assert np.all(np.abs(principal(stress) - expected) <= 2e-7 * scale + 1e-3)
    assert np.all(np.abs(maximum_principal(stress) - expected[:, 0]) <= 2e-7 * scale[:, 0] + 1e-3)


def test_uniaxial_stress_is_exact_enough_to_print() -> None:
    assert np.allclose(principal(np.array([0, 60e6, 0, 0, 0, 0.0])), [60e6, 0, 0], atol=1.0)


def test_stress_in_a_plane_of_symmetry_is_exact() -> None:
    stress = np.array([[5.0, 3.0, -1.0, 0.0, 0.0, 2.0], [-9.0, 3.0, -1.0, 0.0, 0.0, 2.0]])
    high, low = 1 + np.sqrt(8), 1 - np.sqrt(8)
    assert np.array_equal(principal(stress), [[5.0, high, low], [high, low, -9.0]])
    assert maximum_principal(stress[0]).shape == ()


@given(arrays(np.float64, (7, 2, 6), elements=st.floats(-1e9, 1e9)), st.sets(st.integers(0, 13)))
def test_maximum_is_the_first_of_the_three_whatever_lies_beside_it(stress: np.ndarray, plane: set[int]) -> None:
    stress.reshape(-1, 6)[list(plane), 3:5] = 0.0
    expected = principal(stress)[..., 0]
    assert np.array_equal(maximum_principal(stress), expected)
    one_by_one = [[maximum_principal(node) for node in sample] for sample in stress]
    assert np.array_equal(one_by_one, expected)
    components_first = np.ascontiguousarray(stress.transpose(1, 2, 0)).transpose(2, 0, 1)
    assert np.array_equal(maximum_principal(components_first), expected)
    assert maximum_principal(np.zeros((0, 3, 6))).shape == (0, 3)
