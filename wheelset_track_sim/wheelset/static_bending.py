"""Stress of static loads that bend the axle, beside the vertical contact forces, by the harmonics 0 and 1.

A load that moves a section of the axle as a whole is of n = 1; the even part, n = 0, carries axial force. Harmonics
from 2 on end in wheel and hub: of the vertical contact force they are 0.05 % of the stress in a fillet beside a seat.

The axle turns slowly against its vibrations, so a load that is fixed in space gives static stress that is fixed in
space, through which the points of the axle turn: centrifugal and Coriolis forces are left out, as in the paper. The
axle boxes hold the wheelset in two places, so their stiffness has no part in it; a bearing takes its force evenly.
"""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import Real
from .around import Around
from .harmonics import HarmonicModel, bearing_surfaces, contact_displacements, harmonic, on_surface
from .mesh import wheelset_mesh
from .section_mesh import SectionMesh
from .stress_points import surface_amplitudes
from .wheelset import Wheelset


def own_weight_stress(wheelset: Wheelset, y: Real) -> Around:
    """Work out the stress that own weight adds: that of the wheelset under gravity, hung up in its axle boxes.

    With contact forces of 2 P in all, the journals carry 2 P - W, and 2 P if the wheelset weighs nothing. The
    difference is W, the weight of all but the axle boxes, as a body force, and W upwards from the journals. Axle boxes
    stand on the journals, where the suspension presses on them: their weight makes no stress.

    Parameters
    ----------
    wheelset
        By its geometry.
    y
        (N,) places on the axle's free surface, m.

    Returns
    -------
    Around
        Stress at the places, Pa.
    """
    mesh = wheelset_mesh(wheelset)
    model = harmonic(wheelset, mesh, 1)
    return Around.vertical(_amplitudes(wheelset, mesh, model, model.weight(), y))


def longitudinal_stress(wheelset: Wheelset, y: Real, wheel_1_share: float) -> Around:
    """Work out the bending by the longitudinal forces with which both rails react to a torque of 1 N m.

    They are ``share / R`` forwards at the contacts, and the axle boxes hold them: bending in the horizontal plane. The
    moment of the torque itself is torsion, which ``static_loads.torsion_stress`` has.

    Parameters
    ----------
    wheelset
        By its geometry.
    y
        (N,) places on the axle's free surface, m.
    wheel_1_share
        Share of the torque that rail 1 takes.

    Returns
    -------
    Around
        Stress at the places for each N m, Pa.
    """
    mesh = wheelset_mesh(wheelset)
    model = harmonic(wheelset, mesh, 1)
    forces = np.array([wheel_1_share, 1.0 - wheel_1_share]) / wheelset.rolling_radius
    load = model.free.T @ (contact_displacements(wheelset, mesh, "forward") @ forces)
    return Around.horizontal(_amplitudes(wheelset, mesh, model, load, y))


def lateral_stress(wheelset: Wheelset, y: Real, forces: Real) -> Around:
    """Work out the stress of lateral forces on the wheels at their contacts.

    The axle boxes hold them by halves along y. The rails take the moment about x: the vertical forces of the contacts
    change by ``transferred``. EN 13103-1 has the same statics, with its Y1, Y2 and H.

    Parameters
    ----------
    wheelset
        By its geometry.
    y
        (N,) places on the axle's free surface, m.
    forces
        (2,) on wheel 1 and 2, to the left positive, N.

    Returns
    -------
    Around
        Stress at the places, Pa.
    """
    mesh = wheelset_mesh(wheelset)
    model = harmonic(wheelset, mesh, 1)
    sideways = contact_displacements(wheelset, mesh, "left") @ forces
    upwards = contact_displacements(wheelset, mesh, "up") @ transferred(wheelset, forces)
    bending = _amplitudes(wheelset, mesh, model, model.free.T @ (sideways + upwards), y)

    axial = harmonic(wheelset, mesh, 0)
    held = sideways + upwards
    for surface in bearing_surfaces(wheelset):
        nodes, weights = on_surface(mesh, *surface)
        np.add.at(held, 3 * nodes + 1, -forces.sum() / 2 * weights)
    along = _amplitudes(wheelset, mesh, axial, axial.free.T @ held, y)
    return Around.vertical(bending) + Around.even(along)


def transferred(wheelset: Wheelset, forces: Real) -> Real:
    """What lateral forces (2,), N, to the left, add to the vertical forces of both contacts, (2,) N.

    About x: ``R (Y_1 + Y_2) + y_1 Q_1 + y_2 Q_2 = 0`` with ``Q_1 = -Q_2``; axle boxes at the height of the axle take
    the lateral force, and their vertical forces stay.
    """
    first, second = wheelset.contact_positions
    load = wheelset.rolling_radius * forces.sum() / (second - first)
    return np.array([load, -load])


def _amplitudes(wheelset: Wheelset, mesh: SectionMesh, model: HarmonicModel, load: Real, y: Real) -> Real:
    """Amplitudes (N, 6) of stress at places ``y`` under a load (free unknowns,)."""
    return surface_amplitudes(wheelset, mesh, model.n, model.free @ model.static(load), y)
