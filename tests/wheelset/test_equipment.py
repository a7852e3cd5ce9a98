"""Rings and point masses on the axle, against closed forms of beams."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
import scipy
import scipy.sparse as sp
from scipy.linalg import eigh
from scipy.sparse.linalg import spsolve

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.wheelset.harmonic_elements import free_unknowns, stiffness_and_mass
from wheelset_track_sim.wheelset.harmonics import section_motion
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.parts import Material
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.section_mesh import divided, grid, joined
from wheelset_track_sim.wheelset.wheelset import PointMass, Ring, Wheelset

STEEL = Material(density=7810.0, youngs_modulus=210e9, poissons_ratio=0.3, mass_damping=0.0, stiffness_damping=0.0)
RADIUS, LENGTH = 0.03, 2.0  # slender: the beam of Euler and Bernoulli serves
AREA, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
EI, LINE = STEEL.youngs_modulus * SECOND, STEEL.density * AREA


def pinned_shaft() -> tuple[sp.csc_array, sp.csc_array, np.ndarray]:
    """Stiffness and mass of a shaft on two supports, and what reads lift and tilt of 40 mm in its middle."""
    breaks = [0.0, LENGTH / 2 - 0.02, LENGTH / 2 + 0.02, LENGTH]
    mesh = joined([grid(divided(breaks, 0.05)[:, None], divided([0.0, RADIUS], 0.015)[None, :])])
    ends = (mesh.points[:, 0] == 0.0) | (np.abs(mesh.points[:, 0] - LENGTH) < 1e-9)
    held = np.repeat(ends, 3) & (np.arange(3 * len(ends)) % 3 != 1)
    free = free_unknowns(mesh, 1)
    free = free[:, np.flatnonzero(free.T @ held == 0)]
    stiffness, mass = (free.T @ matrix @ free for matrix in stiffness_and_mass(mesh, STEEL, 1))
    return stiffness, mass, free.T @ section_motion(mesh, RADIUS, LENGTH / 2 - 0.02, LENGTH / 2 + 0.02)


def natural_frequencies(mass: float, inertia: float) -> np.ndarray:
    stiffness, own, motion = pinned_shaft()
    whole = own.toarray() + motion @ np.diag([mass, inertia]) @ motion.T
    values = eigh(stiffness.toarray(), whole, eigvals_only=True, subset_by_index=[0, 1])
    return np.sqrt(values) / (2 * np.pi)


def frequency_of(p: float) -> float:
    """Hz of the wave number 2 p / L."""
    return float((2 * p / LENGTH) ** 2 * np.sqrt(EI / LINE) / (2 * np.pi))


@pytest.mark.parametrize("share", [0.5, 5.0])
def test_mass_in_the_middle_of_a_beam(share: float) -> None:
    """Symmetric modes: tan p - tanh p = 2 (m L / M) / p with p = k L / 2; the antisymmetric one stays, p = pi."""
    mass = share * LINE * LENGTH
    p = scipy.optimize.brentq(lambda p: np.tan(p) - np.tanh(p) - 2 / (share * p), 0.1, np.pi / 2 - 1e-9)
    first, second = natural_frequencies(mass, 0.0)
    assert first == pytest.approx(frequency_of(p), rel=0.005)
    assert second == pytest.approx(frequency_of(np.pi), rel=0.01)


def test_inertia_in_the_middle_of_a_beam() -> None:
    """Antisymmetric modes: J k^3 / (4 m) (coth p - cot p) = 1; the symmetric one stays, p = pi / 2."""
    inertia = 0.2 * LINE * LENGTH**3 / 12
    p = scipy.optimize.brentq(
        lambda p: inertia * (2 * p / LENGTH) ** 3 / (4 * LINE) * (1 / np.tanh(p) - 1 / np.tan(p)) - 1, 0.5, np.pi - 1e-9
    )
    first, second = natural_frequencies(0.0, inertia)
    assert first == pytest.approx(frequency_of(np.pi / 2), rel=0.005)
    assert second == pytest.approx(frequency_of(p), rel=0.01)
    assert second < 0.9 * frequency_of(np.pi)


def test_sag_under_a_weight() -> None:
    """F L^3 / (48 EI), and a little shear."""
    stiffness, _, motion = pinned_shaft()
    sag = motion[:, 0] @ spsolve(stiffness.tocsc(), motion[:, 0])
    shear = 6 * (1 + 0.3) / (7 + 6 * 0.3) * STEEL.youngs_modulus / 2.6 * AREA
    assert sag == pytest.approx(LENGTH**3 / (48 * EI) + LENGTH / (4 * shear), rel=0.003)


@pytest.mark.slow
def test_a_mass_slows_the_bounce(x40: Wheelset) -> None:
    coarse = replace(x40, mesh=x40.mesh.divided(0.5), stress_nodes=())
    motor = PointMass("motor", y=0.0, length=0.1, mass=400.0, inertia=30.0)
    bare, loaded = (
        build_reduced_wheelset(replace(coarse, equipment=items), max_frequency=50.0) for items in ((), (motor,))
    )
    assert loaded.mass - bare.mass == pytest.approx(400.0)
    assert loaded.frequencies[0] / bare.frequencies[0] == pytest.approx(np.sqrt(bare.mass / loaded.mass), rel=0.002)
    # Standing, the suspension carries both alike.
    standing = [model.static_receptance() + model.displacement_residual for model in (bare, loaded)]
    assert standing[0] == pytest.approx(standing[1], rel=1e-9)


@pytest.mark.slow
def test_a_ring_is_what_a_gearbox_is(x40: Wheelset) -> None:
    """The same hollow cylinder under another name gives the same wheelset."""
    assert x40.gearbox is not None
    coarse = replace(x40, mesh=x40.mesh.divided(0.5), stress_nodes=())
    ring = Ring("gear", y=x40.gearbox.y, length=x40.gearbox.length, outer_radius=x40.gearbox.outer_radius)
    one = build_reduced_wheelset(coarse, max_frequency=300.0)
    other = build_reduced_wheelset(replace(coarse, gearbox=None, equipment=(ring,)), max_frequency=300.0)
    assert other.frequencies == pytest.approx(one.frequencies, rel=1e-6)
    assert other.mass == pytest.approx(one.mass)


@pytest.mark.parametrize(
    ("item", "message"),
    [
        ({"type": "ring", "name": "disc", "y": 0.0, "length": 0.1, "outer_radius": 0.08}, "seat = 0.09 m is not less"),
        ({"type": "ring", "name": "disc", "y": 0.25, "length": 0.1, "outer_radius": 0.3}, "does not sit on the cyl"),
        ({"type": "ring", "name": "gearbox", "y": 0.0, "length": 0.1, "outer_radius": 0.3}, "and not gearbox"),
        ({"type": "ring", "name": "", "y": 0.0, "length": 0.1, "outer_radius": 0.3}, "empty name"),
        ({"type": "mass", "name": "gear", "y": 0.4, "length": 0.1, "mass": 50.0}, "gear begins at .* inside gearbox"),
        ({"type": "mass", "name": "gear", "y": 0.0, "length": 0.1, "mass": -1.0}, "mass = -1 kg is out of range"),
        ({"type": "spring", "name": "gear", "y": 0.0, "length": 0.1}, "known are ring, mass"),
    ],
)
def test_bad_equipment_is_refused(item: dict[str, object], message: str) -> None:
    plain = asdict(load_wheelset("x40"))
    plain["equipment"] = [item]
    with pytest.raises(InputError, match=message) as refusal:
        load_wheelset(plain)
    assert "\n" not in str(refusal.value)
