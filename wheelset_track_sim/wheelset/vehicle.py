"""The vehicle above a wheelset: a bogie frame and a car body on each side, as further degrees of freedom.

Problem. A wheelset has modes eta of unit modal mass on primary springs whose upper ends are fixed. On each side these
ends now stand under a part of the bogie frame, and this under the car body::

    eta'' + D eta' + Omega^2 eta - b (k_1 w + c_1 w') = s F          b  lift of the modes at the axle boxes, (P, 2)
    m_b w'' + (c_1 + c_2) w' + (k_1 + k_2) w                          s  lift of the modes at the contacts, (P, 2)
            - b^T (k_1 eta + c_1 eta') - k_2 z - c_2 z' = 0           w, z  lift of frame and body on each side, (2,) m
    m_c z'' + (c_2 + c_0) z' + (k_2 + k_0) z - k_2 w - c_2 w' = 0     F  N on wheel 1 and 2

    k_1, c_1  primary suspension of one box      k_2, c_2  secondary one of that side

Without ``body_mass`` the body does not move, z = 0. With it, the body of mass m_c has a pole of its own: with k_0 =
m_c (2 pi FLOAT)^2 it floats at FLOAT on a spring, which carries the static load. The equations are those of mass,
damping and stiffness matrices, whose undamped modes take the place of the wheelset's.

Stress. A force on a box lifts a wheelset on fixed springs without straining it: the spring at that box takes it up. The
modes that are kept strain it by sigma Omega^-2 b, because those above the band are missing, so that much is taken off
for k_1 w. What is left answers to the contact forces alone, as it has to: two contacts on two boxes are statically
determinate, and no suspension changes the static stress.

Accuracy. Nothing but the wheelset's own modes is truncated. Sides are as far apart as the axle boxes, and the frame's
two sides move by themselves: its inertia in roll is that of two masses there. The second wheelset of a bogie is taken
to do the same, so bounce is right for waves much longer than its wheelbase, and pitch is left out.

Source: Newton's equations; static residuals as in ``reduction``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag, eigh

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, plain, quantity, read, unknown
from ..runtime.arrays import Real

FLOAT = 0.1
"""Frequency, Hz, at which a car body floats on what carries its weight; it takes 1 % off the body's inertia at 1 Hz."""
FLOAT_DAMPING = 0.1
"""Damping ratio of that."""
LONGEST_SETTLING = 10.0
"""s; for a vehicle that is hardly damped."""


@dataclass(frozen=True)
class Vehicle:
    """Bogie frame and car body above the primary suspension, on one side of one wheelset. SI units."""

    bogie_mass: float = quantity("kg", 10.0, 1e6, "the mass of the bogie frame on this side")
    secondary_stiffness: float = quantity("N/m", 1e4, 1e9, "the vertical stiffness of the secondary suspension")
    secondary_damping: float = quantity("N s/m", 0.0, 1e6, "the vertical damping of the secondary suspension")
    body_mass: float | None = quantity(
        "kg", 100.0, 2e4, "the mass of the car body on this side, or none for a body that does not move", default=None
    )
    """Mass of the car body on this side, kg; None for one that does not move."""
    name: str = "vehicle"

    def __post_init__(self) -> None:
        check(self)

    def matrices(self, spring: float, dashpot: float) -> tuple[Real, Real, Real]:
        """Mass, damping and stiffness (E, E) of frame and body of one side on a primary ``spring`` and ``dashpot``."""
        mass, c, k = np.array([self.bogie_mass]), self.secondary_damping, self.secondary_stiffness
        damping, stiffness = np.array([[dashpot + c]]), np.array([[spring + k]])
        if self.body_mass is not None:
            omega = 2 * math.pi * FLOAT
            mass = np.array([self.bogie_mass, self.body_mass])
            damping = np.array([[dashpot + c, -c], [-c, c + 2 * FLOAT_DAMPING * omega * self.body_mass]])
            stiffness = np.array([[spring + k, -k], [-k, k + omega**2 * self.body_mass]])
        return np.diag(mass), damping, stiffness

    def settling(self, spring: float, dashpot: float) -> float:
        """Time, s, in which what the wheels have excited decays to 1 % of it, ``LONGEST_SETTLING`` at most."""
        M, C, K = self.matrices(spring, dashpot)
        system = np.block([[np.zeros_like(M), np.eye(len(M))], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        slowest = -float(np.linalg.eigvals(system).real.max())
        return min(LONGEST_SETTLING, math.log(100.0) / slowest) if slowest > 0.0 else LONGEST_SETTLING


class OnVehicle(NamedTuple):
    """Modes of unit modal mass of a wheelset under its vehicle: Q = P + E a side, of P of the wheelset."""

    omega: Real
    """(Q,) rad/s, undamped."""
    damping: Real
    """(Q, Q) modal matrix."""
    shapes: Real
    """(P, Q) the wheelset's own modes in them."""
    frame: Real
    """(Q, 2) lift of the frame's sides above the axle boxes."""
    stress: Real
    """(rows, Q) of stress."""


def on_vehicle(
    omega: Real, damping: Real, boxes: Real, stress: Real, spring: float, dashpot: float, vehicle: Vehicle
) -> OnVehicle:
    """Couple the modes of a wheelset to its vehicle, as derived above.

    Parameters
    ----------
    omega, damping
        Undamped frequencies (P,), rad/s, and the modal matrix (P, P) of modes of unit modal mass on fixed springs, with
        what the primary dashpots add.
    boxes, stress
        Lift of the modes at the axle boxes, (P, 2), and their stress, (rows, P).
    spring, dashpot
        Of the primary suspension of one box, N/m and N s/m.
    vehicle
        What stands on each side.
    """
    M, C, K = (np.kron(side, np.eye(2)) for side in vehicle.matrices(spring, dashpot))
    reach = np.zeros((len(omega), len(M)))
    reach[:, :2] = boxes  # the frame's sides come first
    mass = block_diag(np.eye(len(omega)), M)
    squares, shapes = eigh(np.block([[np.diag(omega**2), -spring * reach], [-spring * reach.T, K]]), mass)
    dashpots = np.block([[damping, -dashpot * reach], [-dashpot * reach.T, C]])
    strained = np.hstack([stress, -spring * (stress / omega**2) @ reach])
    return OnVehicle(
        omega=np.sqrt(squares),
        damping=shapes.T @ dashpots @ shapes,
        shapes=shapes[: len(omega)],
        frame=shapes[len(omega) : len(omega) + 2].T,
        stress=strained @ shapes,
    )


def load_vehicle(source: str | Path | Mapping[str, Any]) -> Vehicle:
    """Load a vehicle.

    Parameters
    ----------
    source
        Name of a shipped vehicle (``coach``, ``power_car``), path of a YAML file, or a mapping with the keys of such a
        file.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.

    Examples
    --------
    >>> load_vehicle("power_car").bogie_mass
    1407.7
    """
    if isinstance(source, Mapping):
        return read(Vehicle, source, "vehicle")
    return read(Vehicle, shipped.load_yaml("vehicles", source), "vehicle")


def read_vehicle(data: Any, where: str) -> Vehicle | None:
    """Vehicle from the name of a shipped one or from a mapping, or None; ``where`` is the key that messages begin with.

    Raises InputError.
    """
    if data is None or isinstance(data, Vehicle):
        return data
    if isinstance(data, str):
        if data not in shipped.names("vehicles"):
            raise InputError(unknown("vehicle", f"{where} = {data!r}", data, shipped.names("vehicles")))
        return _shipped(data)
    return read(Vehicle, data, where)


def plain_vehicle(vehicle: Vehicle | None) -> Any:
    """Name of a shipped vehicle, or a mapping of all that a vehicle is; ``read_vehicle`` reads both."""
    if vehicle is None:
        return None
    if vehicle.name in shipped.names("vehicles") and vehicle == _shipped(vehicle.name):
        return vehicle.name
    return plain(vehicle)


@cache
def _shipped(name: str) -> Vehicle:
    return read(Vehicle, shipped.load_yaml("vehicles", name), "vehicle")
