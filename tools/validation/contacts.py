"""Section 4: the contact against Hertz's theory and against ContactMechanics."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from wheelset_track_sim.contact import (
    ContactGeometry,
    HertzContact,
    ProfilePair,
    RailHead,
    build_contact_law,
    solve_patch,
)
from wheelset_track_sim.contact.law import ELEMENT_WIDTH
from wheelset_track_sim.contact.law_kernels import total_separation
from wheelset_track_sim.irregularities import Breakout

from .page import exponent, paragraphs, table
from .store import recall

GRIDS = ((1e-3, 1e-3), (1e-3, ELEMENT_WIDTH), (5e-4, 5e-4))
"""Lengths and widths of elements, m; the second is what the software runs on."""
FORCES = (20e3, 100e3, 350e3)
DEFECTS = (
    ("C, 2 mm, middle", Breakout("wheel_1", 0.030, 0.024, 0.002), 0),
    ("C, 2 mm, 22 mm off", Breakout("wheel_1", 0.030, 0.024, 0.002), 22),
    ("A, 0.3 mm, middle", Breakout("wheel_1", 0.010, 0.008, 0.0003), 0),
    ("A, 0.3 mm, 6 mm off", Breakout("wheel_1", 0.010, 0.008, 0.0003), 6),
    ("20 × 10, 0.6 mm, 4 mm aside", Breakout("wheel_1", 0.020, 0.010, 0.0006, y=0.004), 5),
    ("smooth", Breakout("wheel_1", 0.020, 0.010, 0.0006, y=0.004), 500),
)
PACKAGES = ("ContactMechanics", "SurfaceTopography")


def missing() -> list[str]:
    """Packages of the test extra that this section needs and that are not there."""
    return [name for name in PACKAGES if importlib.util.find_spec(name) is None]


def _hertz() -> Any:
    rows = []
    for name, head in (("R300", RailHead(radii=(0.3,), ends=(0.036,))), ("60E1", RailHead())):
        geometry = ContactGeometry(pairs=(ProfilePair(rail=head),) * 2)
        theory = HertzContact(geometry.wheel_radius, 0.3, geometry.contact_modulus)
        for dx, dy in GRIDS:
            law = build_contact_law([], geometry, dx, round(2.713 / dx), dy=dy, tables=False)
            for force in FORCES:
                patch = solve_patch(law, 0, 0, 0, theory.approach(force))
                pressure = patch.pressure.max() / theory.peak_pressure(force) - 1
                rows.append([name, dx, dy, force, patch.force / force - 1, pressure, theory.peak_pressure(force)])
    return rows


def _half_spaces() -> Any:
    import ContactMechanics
    from SurfaceTopography import Topography  # type: ignore[import-untyped]

    dx, rows = 1e-3, []
    for name, defect, tread in DEFECTS:
        geometry = ContactGeometry()
        law = build_contact_law([defect], geometry, dx, 2713, tables=False)
        gap = total_separation(law, 0, tread, 0)
        approach = gap.min() + 2.5e-4
        patch = solve_patch(law, 0, tread, 0, approach)
        # Lengths in dx, stresses in E*; asked at a force, for at an approach its method can cycle.
        size = (float(gap.shape[0]), gap.shape[1] * ELEMENT_WIDTH / dx)
        system = ContactMechanics.make_system(
            substrate=ContactMechanics.FreeFFTElasticHalfSpace(gap.shape, 1.0, size),
            surface=Topography(-np.minimum(gap, 0.1) / dx, size),
        )
        force = patch.force / (geometry.contact_modulus * dx**2)
        result = system.minimize_proxy(external_force=force, pentol=1e-9, forcetol=1e-9, maxiter=3000)
        other = np.asarray(result.jac)[: gap.shape[0], : gap.shape[1]] * geometry.contact_modulus * dx / ELEMENT_WIDTH
        error = np.abs(patch.pressure - other).max() / other.max()
        rows.append([name, patch.force, patch.pressure.max(), float(error), float(result.offset * dx / approach - 1)])
    return rows


def hertz() -> Any:
    """Crown, element length and width, force, and errors of force and pressure against Hertz."""
    return recall("hertz", [FORCES], _hertz)


def spaces() -> Any:
    """Defect, force, largest pressure, and differences of pressures and approach to ContactMechanics."""
    return recall("half-spaces", [[name, tread] for name, _, tread in DEFECTS], _half_spaces)


def section() -> str:
    """Text of the section."""
    near = [
        [f"{name}, {dx * 1e3:g} × {dy * 1e3:g} mm", force / 1e3, pressure / 1e9, 100 * of_force, 100 * of_pressure]
        for name, dx, dy, force, of_force, of_pressure, pressure in hertz()
    ]
    other = [
        [name, force / 1e3, pressure / 1e9, exponent(error), exponent(abs(offset))]
        for name, force, pressure, error, offset in spaces()
    ]
    return paragraphs(
        "## 4. Contact",
        "Active set against Hertz's point contact (closed form, Carlson's integrals), at the "
        "approach at which Hertz's force is 20, 100 and 350 kN; wheel radius 431.75 mm on a crown of R300 alone, and "
        "on the 60E1 crown, whose R300 ends 10.2 mm from the middle:",
        table(("crown, elements", "Hertz, kN", "peak, GPa", "force, %", "peak pressure, %"), near, (0, 0, 3, 2, 2)),
        "Against the half-space solver of ContactMechanics (FFT, Polonsky and Keer's method) with a defect in the "
        "patch, on our elements, at the same force; the largest difference in pressure over its maximum:",
        table(("defect", "force, kN", "peak, GPa", "pressures", "approach"), other, (0, 1, 3, 0, 0)),
    )
