"""Section 12: what the vehicle above the wheelset does, against masses alone and against the linear response."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np

from wheelset_track_sim.errors import InputWarning
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.reduction import reduced_wheelset
from wheelset_track_sim.wheelset.vehicle import Vehicle, load_vehicle

from .page import paragraphs, table
from .store import recall

SCENARIO, WAVE, HEIGHT = "long_wave", 20.0, 0.010
"""Wave of the scenario: length and amplitude, m."""
FREQUENCIES = (0.5, 1.0, 1.39, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0)


def _vehicles() -> dict[str, Vehicle | None]:
    moving = load_scenario(SCENARIO).vehicle
    return {"upper ends held": None, "power_car": load_vehicle("power_car"), "the same, its body moves": moving}


def _masses(wheelset: str, vehicle: Vehicle | None, frequency: float) -> complex:
    """Displacement of one side over its force, m/N, of a rigid wheelset below the masses and springs of a vehicle."""
    model, s = load_wheelset(wheelset), 2j * np.pi * frequency
    k, c = model.axle_boxes.stiffness, model.axle_boxes.damping
    inertia = s**2 * reduced_wheelset(model).mass / 2
    if vehicle is None:
        return complex(1 / (k + s * c + inertia))
    mass, damping, stiffness = vehicle.matrices(k, c)
    above = 1 / np.linalg.inv(stiffness + s * damping + s**2 * mass)[0, 0] - (k + s * c)
    return complex(1 / (1 / (1 / (k + s * c) + 1 / above) + inertia))


def _receptances() -> list[list[float]]:
    """At each frequency, of each vehicle: the wheelset's receptance under equal forces, nm/N, and the masses' alone."""
    rows: list[list[float]] = []
    reduced = {name: reduced_wheelset(load_wheelset("x40"), vehicle=each) for name, each in _vehicles().items()}
    for frequency in FREQUENCIES:
        row = [frequency]
        for name, vehicle in _vehicles().items():
            found = reduced[name].receptance(np.array([frequency]))[0].sum(axis=1).mean()
            row += [1e9 * abs(found), 1e9 * abs(_masses("x40", vehicle, frequency))]
        rows.append(row)
    return rows


def _waves() -> list[list[float]]:
    """Of each vehicle: amplitude of the force over the wave, kN, and that of the linear response."""
    rows = []
    for vehicle in _vehicles().values():
        scenario = dataclasses.replace(load_scenario(SCENARIO), vehicle=vehicle)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)  # of what this section is about
            simulator = Simulator(scenario)
        simulator.settle()
        steps = round(WAVE / scenario.step_length)
        force = simulator.advance(3 * steps).forces[:, 0]
        found = 2 * abs(np.mean(force * np.exp(-2j * np.pi * np.arange(3 * steps) / steps)))
        of_wheelset = simulator.models.reduced.receptance(np.array([scenario.speed / WAVE]))[0].sum(axis=1)[0]
        track = simulator.models.dynamics.track.symmetric.compliance().mean()
        rows.append([found / 1e3, HEIGHT / abs(of_wheelset + track + 1e-9) / 1e3])
    return rows


def section() -> str:
    """Text of the section."""
    names = list(_vehicles())
    rows = recall("vehicle-receptances", list(FREQUENCIES), _receptances)
    off = {row[0]: 100 * (row[1] / row[5] - 1) for row in rows}
    waves = recall("long-wave", [SCENARIO, WAVE, HEIGHT], _waves)
    return paragraphs(
        "## 12. The vehicle above",
        "By default the upper ends of the axle-box springs are held. This is right above 15 to 20 Hz, where bogie "
        "frame and car body do not follow. `vehicle:` in a scenario couples both to the modes of the wheelset "
        "([wheelsets.md](reference/wheelsets.md)). Magnitude of the receptance of `x40` under equal forces on both "
        "wheels, nm/N, beside that of a rigid wheelset with the same masses and springs:",
        table(
            ("Hz", *(title for name in names for title in (name, "masses alone"))),
            rows,
            (2, *(1,) * 2 * len(names)),
        ),
        f"A wave of {WAVE:g} m and {1e3 * HEIGHT:g} mm in amplitude in both rails, passed at 100 km/h, or 1.4 Hz: "
        "amplitude of the force of wheel 1, and of the linear response of wheelset, track and contact:",
        table(
            ("vehicle", "simulated, kN", "linear, kN"),
            [[name, *row] for name, row in zip(names, waves, strict=True)],
            (0, 2, 2),
        ),
        "* Over long waves a wheelset with held springs makes several times the force that a vehicle has. A run warns "
        "when its waves pass below 15 Hz without a vehicle and would make more than 1 % of the wheel load.\n"
        f"* With held springs the receptance is {off[15.0]:.0f} % too high at 15 Hz and {off[30.0]:.0f} % at 30 Hz. "
        "Impacts, which last some milliseconds, need no vehicle.",
    )
