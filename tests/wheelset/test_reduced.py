"""The type: its equations, what it refuses, how it is stored."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.runtime import cache
from wheelset_track_sim.wheelset.reduced import ReducedWheelset


def two_oscillators() -> tuple[ReducedWheelset, np.ndarray, np.ndarray, np.ndarray]:
    """One underdamped and one overdamped mode, with the modal data that made them."""
    omega, zeta = np.array([100.0, 40.0]), np.array([0.1, 1.5])
    shapes = np.array([[1.0, 0.3], [-0.2, 0.8]])  # (modes, wheels)
    decay, root = zeta * omega, np.sqrt(zeta**2 - 1 + 0j) * omega
    # u'' + 2 zeta omega u' + omega^2 u = f: one upper pole, or two real ones.
    poles = np.array([-decay[0] + root[0], -decay[1] + root[1], -decay[1] - root[1]])
    right = np.array([2 / (2 * root[0]), 1 / (2 * root[1]), -1 / (2 * root[1])])
    modal = shapes[[0, 1, 1]]
    reduced = ReducedWheelset(
        poles=poles,
        inputs=modal.astype(complex),
        outputs=modal.T * right,
        stress_outputs=np.broadcast_to(3.0 * modal.T[:1] * right, (1, 6, 3)).copy(),
        stress_feedthrough=np.full((1, 6, 2), 0.5),
        displacement_residual=np.zeros((2, 2)),
        node_names=("A1",),
        node_positions=np.zeros((1, 3)),
        mass=1.0,
        rolling_radius=0.4,
    )
    return reduced, omega, zeta, shapes


def test_receptance_is_that_of_the_oscillators() -> None:
    reduced, omega, zeta, shapes = two_oscillators()
    frequencies = np.linspace(0.0, 40.0, 17)
    w = 2 * np.pi * frequencies[:, None]
    modal = 1 / (omega**2 - w**2 + 2j * zeta * omega * w)
    expected = np.einsum("mi,fm,mj->fij", shapes, modal, shapes)
    assert reduced.receptance(frequencies) == pytest.approx(expected, rel=1e-12)
    stress = 3.0 * np.einsum("m,fm,mj->fj", shapes[:, 0], modal, shapes) + 0.5
    assert reduced.stress_receptance(frequencies)[:, 0, 4] == pytest.approx(stress, rel=1e-12)
    assert reduced.static_stress()[0, 4] == pytest.approx(stress[0].real, rel=1e-12)
    assert reduced.static_receptance() == pytest.approx(expected[0].real, rel=1e-12)


@pytest.mark.slow
def test_round_trip_through_a_file(reduced_x40: ReducedWheelset, tmp_path: Path) -> None:
    cache.store(tmp_path / "wheelset.npz", reduced_x40)
    with np.load(tmp_path / "wheelset.npz", allow_pickle=False) as stored:
        again = ReducedWheelset.from_arrays(dict(stored))
    for field in fields(ReducedWheelset):
        before, after = getattr(reduced_x40, field.name), getattr(again, field.name)
        assert type(before) is type(after)
        assert np.array_equal(before, after)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"inputs": np.zeros((2, 2), complex)}, r"inputs has shape \(2, 2\): give \(3, 2\)"),
        ({"poles": np.array([1.0 + 2j, -1.0, -1.0])}, "negative real parts"),
        ({"poles": np.array([-1.0 - 2j, -1.0, -1.0])}, "imaginary parts of at least 0"),
        ({"stress_feedthrough": np.full((1, 6, 2), np.nan)}, "stress_feedthrough has values that are not finite"),
    ],
)
def test_imported_modes_are_checked(change: dict[str, np.ndarray], message: str) -> None:
    reduced, *_ = two_oscillators()
    with pytest.raises(InputError, match=message):
        replace(reduced, **change)


def test_unknown_node_is_refused() -> None:
    reduced, *_ = two_oscillators()
    assert reduced.node("A1") == 0
    with pytest.raises(InputError, match=r"D1 is not known: known are A1"):
        reduced.node("D1")
