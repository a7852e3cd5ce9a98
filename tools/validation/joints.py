"""Section 10: the P2 force at dipped joints against Jenkins' formula and an exact model of one mass."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.linalg

from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track import bloch

from .page import number, paragraphs, table
from .runs import shared_models
from .store import recall

ANGLE = 0.010
"""Of the joints, 2 alpha, rad, the mean of a British survey that the formula is usually fed with."""
SPEEDS = (72, 100, 144)
"""km/h"""
LENGTHS = (1.0, 2.0, 4.0)
"""Of both dipped ends together, m."""
WHEELSETS = ("x40", "trailer")
POSITION = 6.0
"""Of the first joint, m: above a sleeper."""
BAND = (10.0, 60.0)
"""Frequencies of the fitted track, Hz."""
OVER = 2e-3
"""Time after the joint at which the high and short peak P1 is over, s."""
PLACES = 4
"""Of the joint in a bay."""


@lru_cache(maxsize=1)
def fitted_track() -> tuple[float, float, float]:
    """Stiffness, N/m, mass, kg, and damping, Ns/m, of one rail under equal forces on both, least squares over BAND."""
    track, f = load_scenario("undamaged").track, np.linspace(*BAND, 26)
    places = np.arange(12) * track.spacing / 12
    both = np.mean([sum(part[0] for part in bloch.receptance(track, f, x, [x])) for x in places], axis=0)
    omega = 2 * np.pi * f
    stiffness = 1 / both
    (k, m), *_ = np.linalg.lstsq(np.stack([np.ones_like(f), -(omega**2)], axis=1), stiffness.real, rcond=None)
    c = float(omega @ stiffness.imag / (omega @ omega))
    return float(k), float(m), c


def jenkins(static: float, speed: float, unsprung: float, k: float, m: float, c: float) -> float:
    """P2 = P0 + 2 alpha v sqrt(Mu / (Mu + Mt)) (1 - pi ct / (4 sqrt(kt (Mu + Mt)))) sqrt(kt Mu), N."""
    both = unsprung + m
    damped = 1 - np.pi * c / (4 * np.sqrt(k * both))
    return float(static + ANGLE * speed * np.sqrt(unsprung / both) * damped * np.sqrt(k * unsprung))


def one_mass(static: float, speed: float, unsprung: float, length: float) -> float:
    """P2 of a mass that rolls on the fitted track without a contact spring, N.

    M y'' + c y' + k y = f with M = Mu + Mt: y is the track's deflection, f = -Mu v^2 times the curvature of the dip,
    which is constant on both ends, and the kink is a jump of y' by Mu 2 alpha v / M. The force on the track is
    k y + c y' + Mt y''; the impulse in it at the kink is P1, and left out. Each step is exact.
    """
    k, m, c = fitted_track()
    both, half, dt = unsprung + m, length / 2, 1e-5
    curved = -unsprung * ANGLE / length * speed**2
    A = np.array([[0.0, 1.0, 0.0], [-k / both, -c / both, 1 / both], [0.0, 0.0, 0.0]])
    step, state, largest = scipy.linalg.expm(A * dt), np.array([0.0, 0.0, curved]), 0.0
    before = round(half / speed / dt)
    for n in range(-before, round(0.05 / dt)):
        if n == 0:
            state[1] += unsprung * ANGLE * speed / both
        if n == before:
            state[2] = 0.0
        if n >= 0:
            largest = max(largest, k * state[0] + c * state[1] + m * (A[1] @ state))
        state = step @ state
    return static + largest


def _simulated(wheelset: str, speed: float, length: float) -> list[float]:
    """P2 of wheel 1 with the joint at PLACES places of a bay, N."""
    found = []
    for place in range(PLACES):
        position = POSITION + place * 0.6 / PLACES
        joints = ", ".join(
            f"{{type: joint, on: {rail}, position: {position}, dip_angle: {ANGLE}, length: {length}, gap: 0.0}}"
            for rail in ("rail_1", "rail_2")
        )
        changes = [f"wheelset={wheelset}", "output.stress_nodes=[A1]", f"speed={speed}", f"irregularities=[{joints}]"]
        scenario = load_scenario("undamaged", changes)
        run = Simulator(scenario, models=shared_models(scenario, "smooth", None))
        force = run.advance(round((position + 2.5) / scenario.step_length)).forces[:, 0]
        since = (np.arange(len(force)) * scenario.step_length - position) / speed
        found.append(float(force[since > OVER].max()))
    return found


def _rows(wheelset: str) -> list[list[float]]:
    scenario = load_scenario("undamaged", [f"wheelset={wheelset}", "output.stress_nodes=[A1]"])
    load, unsprung = scenario.wheel_load, shared_models(scenario, "smooth", None).reduced.mass / 2
    rows = []
    for kmh in SPEEDS:
        speed = kmh / 3.6
        formula = jenkins(load, speed, unsprung, *fitted_track())
        for length in LENGTHS:
            exact, ours = one_mass(load, speed, unsprung, length), _simulated(wheelset, speed, length)
            mean = float(np.mean(ours))
            rise = 100 * (mean - load) / (exact - load) - 100
            rows.append([kmh, length, *(each / 1e3 for each in (formula, exact, mean, min(ours), max(ours))), rise])
    return rows


def rows_of(wheelset: str) -> list[list[float]]:
    """Speed, length, P2 by formula, one mass and causal, least, most, kN, and the last column of the table, %."""
    found: list[list[float]] = recall("joints", [wheelset, SPEEDS, LENGTHS, PLACES], lambda: _rows(wheelset))
    return found


def section() -> str:
    """Text of the section."""
    k, m, c = recall("fitted-track", BAND, lambda: list(fitted_track()))
    rows = []
    for name in WHEELSETS:
        for row in rows_of(name):
            kmh, length, formula, exact, mean, low, high, rise = row
            between = f"{number(low, 0)} to {number(high, 0)}"
            rows.append([name, kmh, length, formula, exact, mean, between, rise])
    return paragraphs(
        "## 10. The P2 force at dipped joints",
        f"Joints of both rails with an angle of {1e3 * ANGLE:g} mrad (2α) and without a gap. *Jenkins* is the formula "
        "of Jenkins et al. (1974), in which the dip has no length. *One mass* is half of the wheelset rolling on the "
        "same track without a contact spring, integrated exactly over the dip. Both take a rail from "
        f"{BAND[0]:g} to {BAND[1]:g} Hz as {k / 1e6:.1f} MN/m, {m:.0f} kg and {c / 1e3:.1f} kNs/m, fitted to its "
        f"receptance. *Causal* is the largest force later than {1e3 * OVER:g} ms after the joint, when P1 is over: the "
        f"mean of {PLACES} places of the joint in a bay, and their range. The last column compares the rise above the "
        "static load of 98.1 kN:",
        table(
            (
                *("wheelset", "km/h", "length, m", "Jenkins, kN", "one mass, kN", "causal, kN", "range"),
                "rise, causal to one mass, %",
            ),
            rows,
            (0, 0, 0, 1, 1, 1, 0, 0),
        ),
        "The formula takes the kink as an impulse on a track at rest, and damping to first order. It is above both "
        "others. The causal dynamics add what one mass and one spring leave out: the bending of the axle, rails and "
        "sleepers of their own, and the contact.",
    )
