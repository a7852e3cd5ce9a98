"""Stress of press fits and torque against closed forms: Lamé, Love's strain function, torsion, Mohr's circle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve
from scipy.special import i0e, i1e

from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.wheelset.around import Around
from wheelset_track_sim.wheelset.harmonic_elements import free_unknowns, stiffness_and_mass
from wheelset_track_sim.wheelset.harmonics import on_surface
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.parts import Axle, AxleSection
from wheelset_track_sim.wheelset.section_mesh import SectionMesh, divided, grid, joined
from wheelset_track_sim.wheelset.static_loads import (
    lame_pressure,
    nominal_torsion,
    press_fit_stress,
    reacted,
    torsion_stress,
)
from wheelset_track_sim.wheelset.wheelset import Wheelset

RADIUS = 0.09
INTERFERENCE = 2.5e-4


@pytest.fixture(scope="module")
def plain() -> Wheelset:
    """The X40 on an axle of one diameter."""
    x40 = load_wheelset("x40")
    axle = Axle(start=-1.11, sections=(AxleSection("shaft", end=1.11, diameter=2 * RADIUS),))
    return replace(x40, axle=axle, stress_nodes=())


def top(stress: Around) -> np.ndarray:
    """Components in x, y, z at the top."""
    return stress.at(np.zeros(len(stress.mean)))


def widening(inner: float, outer: float, pressure: float, *, of_bore: bool) -> float:
    """Radial displacement of a finite-element ring or shaft where hub and shaft meet: at its bore, or outside."""
    mesh = joined([grid(divided([0.0, 0.18], 0.03)[:, None], divided([inner, outer], 0.01)[None, :])])
    steel = load_wheelset("x40").material
    radius = inner if of_bore else outer
    free = free_unknowns(mesh, 0) if inner == 0 else _all_but_torsion(mesh)
    nodes, weights = on_surface(mesh, radius, 0.0, 0.18)
    force = np.zeros(3 * len(mesh.points))
    np.add.at(force, 3 * nodes, pressure * 2 * np.pi * radius * 0.18 * weights)
    stiffness, _ = stiffness_and_mass(mesh, steel, 0)
    reduced = (free.T @ stiffness @ free).tolil()
    axial = int(np.flatnonzero(free[1].toarray().ravel())[0])
    reduced[axial, axial] *= 1e6
    displacements = free @ spsolve(reduced.tocsc(), free.T @ force)
    mean = np.zeros(3 * len(mesh.points))
    np.add.at(mean, 3 * nodes, weights)
    return float(mean @ displacements)


def _all_but_torsion(mesh: SectionMesh) -> sp.csc_array:
    keep = np.flatnonzero(np.arange(3 * len(mesh.points)) % 3 != 2)
    return sp.coo_array((np.ones(len(keep)), (keep, np.arange(len(keep)))), (3 * len(mesh.points), len(keep))).tocsc()


@pytest.mark.parametrize("bore", [0.0, 0.035])
def test_lame_pressure_closes_the_interference(bore: float) -> None:
    """The pressure that widens a hub and narrows a shaft by half the interference together."""
    young = load_wheelset("x40").material.youngs_modulus
    pressure = lame_pressure(young, INTERFERENCE, RADIUS, 0.16, bore)
    hub, shaft = widening(RADIUS, 0.16, pressure, of_bore=True), widening(bore, RADIUS, -pressure, of_bore=False)
    assert hub - shaft == pytest.approx(INTERFERENCE / 2, rel=1e-4)


def band_stress(y: np.ndarray, bands: list[tuple[float, float]], pressure: float) -> np.ndarray:
    """Surface stress (axial, around) of an infinite cylinder under pressure on bands, repeated every 20 m.

    Love's strain function A I0(kr) + B kr I1(kr) for each harmonic cos or sin (k y) of the pressure.
    """
    nu, period = 0.3, 20.0
    axial, around = np.zeros_like(y), np.zeros_like(y)
    for m in range(1, 9000):
        k = 2 * np.pi * m / period
        a = k * RADIUS
        i0, i1 = i0e(a), i1e(a)
        b = 1.0
        c = -2 * (1 - nu) * b - b * a * i0 / i1  # no shear on the surface
        radial = 2 * nu * b * i0 - c * (i0 - i1 / a) - b * (i0 + a * i1)
        along = (2 * (2 - nu) * b + c) * i0 + b * a * i1
        # -(1/r) d phi / dr, and nu times the Laplacian
        hoop = 2 * nu * b * i0 - (c * i1 + b * a * i0) / a
        cosine = sum(np.sin(k * high) - np.sin(k * low) for low, high in bands) * 2 / (k * period)
        sine = sum(np.cos(k * low) - np.cos(k * high) for low, high in bands) * 2 / (k * period)
        wave = -pressure * (cosine * np.cos(k * y) + sine * np.sin(k * y))
        axial += along / radial * wave
        around += hoop / radial * wave
    mean = sum(high - low for low, high in bands) / period * pressure
    return np.stack([axial, around - mean], axis=1)


@pytest.mark.slow
def test_press_fit_beside_the_seats(plain: Wheelset) -> None:
    y = np.array([-0.62, -0.58, -0.5, 0.0, 0.6])  # the nearest 35 mm from the edge, where the pressure jumps
    found = top(press_fit_stress(replace(plain, mesh=plain.mesh.divided(2)), y, INTERFERENCE, 0.0))
    pressure = lame_pressure(plain.material.youngs_modulus, INTERFERENCE, RADIUS, plain.wheel.hub_radius)
    expected = band_stress(y, [(-0.835, -0.655), (0.655, 0.835)], pressure)
    assert found[:, 1] == pytest.approx(expected[:, 0], abs=0.01 * pressure)
    assert found[:, 0] == pytest.approx(expected[:, 1], abs=0.01 * pressure)
    assert expected[0, 0] > 0.2 * pressure  # beside the seat the surface is in tension along the axle
    assert np.abs(found[:, 2]).max() < 0.01 * pressure  # a free surface
    assert np.abs(found[3]).max() < 1e-3 * pressure  # far away


def test_press_fit_is_the_same_around_the_axle(plain: Wheelset) -> None:
    angles = np.array([0.0, 1.0, 2.5])
    found = press_fit_stress(plain, 0 * angles - 0.6, INTERFERENCE, 1e-4).at(angles)
    assert found[:, 1] == pytest.approx(found[0, 1], rel=1e-12)
    assert maximum_principal(found) == pytest.approx(maximum_principal(found)[0], rel=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.2])
def test_torsion_of_a_shaft(plain: Wheelset, share: float) -> None:
    """tau = 16 T / (pi d^3): the share of rail 1 up to the gearbox, that of rail 2 with the other sign behind it."""
    moments = reacted(("gearbox",), share)
    assert sum(moments.values()) == pytest.approx(0.0, abs=1e-12)
    y = np.array([-1.0, -0.3, 0.1, 0.58])
    found = top(torsion_stress(plain, y, moments))
    tau = 16 / (np.pi * (2 * RADIUS) ** 3)
    expected = np.zeros((4, 6))
    expected[:, 3] = tau * np.array([0.0, share, share, share - 1.0])
    assert found == pytest.approx(expected, abs=0.01 * tau)  # 70 mm from gearbox and hub
    places = {"wheel_1": -0.75, "wheel_2": 0.75, "gearbox": 0.403}
    assert top(nominal_torsion(y, [2 * RADIUS] * 4, places, moments)) == pytest.approx(expected, abs=1e-9)


def test_torsion_around_the_shaft(plain: Wheelset) -> None:
    """The shear follows the surface: xy on the top, -yz at the front, turned over at the bottom."""
    angles = np.array([0.0, np.pi / 2, np.pi, 0.6])
    found = torsion_stress(plain, 0 * angles, reacted(("gearbox",), 0.5)).at(angles)
    tau = 8 / (np.pi * (2 * RADIUS) ** 3)
    assert found[:, 3] == pytest.approx(tau * np.cos(angles), abs=0.005 * tau)
    assert found[:, 5] == pytest.approx(-tau * np.sin(angles), abs=0.005 * tau)


def test_torque_at_both_wheels_leaves_the_axle_alone(plain: Wheelset) -> None:
    found = top(torsion_stress(plain, np.zeros(1), reacted(("wheel_1", "wheel_2"), 0.5)))
    assert np.abs(found).max() == pytest.approx(0.0, abs=1e-6)


def test_bending_and_torsion_on_mohrs_circle(plain: Wheelset) -> None:
    torque, bending = 12e3, 60e6
    shear = top(torsion_stress(plain, np.zeros(1), reacted(("gearbox",), 0.5)))[0] * torque
    tau = 8 * torque / (np.pi * (2 * RADIUS) ** 3)
    both = shear + np.array([0.0, bending, 0.0, 0.0, 0.0, 0.0])
    assert maximum_principal(both) == pytest.approx(bending / 2 + np.hypot(bending / 2, tau), rel=1e-4)


def test_a_fillet_concentrates_torsion() -> None:
    """Notch factor between 1 and that of bending there; R. E. Peterson has 1.1 to 1.2 for D/d = 1.07, r/d = 0.2."""
    x40 = load_wheelset("x40")
    y = np.linspace(-0.64, -0.62, 41)
    found = top(torsion_stress(x40, y, reacted(("gearbox",), 0.5)))
    nominal = 8 / (np.pi * 0.180**3)
    assert 1.05 < np.hypot(found[:, 3], found[:, 4]).max() / nominal < 1.3


def test_a_bore_leaves_less_section_to_torsion(plain: Wheelset) -> None:
    """W_t = pi (D^4 - d^4) / (16 D)."""
    bored = replace(plain, axle=replace(plain.axle, bore=0.07))
    full, less = (top(torsion_stress(each, np.zeros(1), reacted(("gearbox",), 0.5))) for each in (plain, bored))
    assert less == pytest.approx(full / (1 - (0.035 / RADIUS) ** 4), rel=0.002, abs=1e-3)
