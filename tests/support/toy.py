"""A wheelset and a track of a few modes: a simulator in milliseconds, built from the numbers below and from no cache.

The wheelset is an imported one: a rigid body that bounces and rolls on its suspension, and two bending modes of the
axle. Under each wheel runs a rail on its pad on a sleeper on its ballast, stiffer above the sleepers. Masses, lowest
frequencies and static stresses are near to those of the X40, but nothing follows from geometry or a mesh.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from wheelset_track_sim.dynamics.causal import causal_model
from wheelset_track_sim.scenario import Scenario, load_scenario, scenario_from
from wheelset_track_sim.sensors.kinds import rows_of
from wheelset_track_sim.simulation.models import Models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.balance import HalfTrack, MovingTrack
from wheelset_track_sim.wheelset.kinds import reduce_wheelset

FREQUENCIES = np.array([7.2, 9.6, 85.0, 206.0])  # Hz: bounce, roll, first and second bending
DAMPING_RATIOS = np.array([0.15, 0.15, 0.01, 0.01])
MODAL_MASSES = np.array([1943.0, 1460.0, 2000.0, 2000.0])  # kg
LIFT = np.array([[1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [1.0, -1.0]])  # of wheel 1 and 2
BOX = np.sqrt(MODAL_MASSES[1] / MODAL_MASSES[0]) * FREQUENCIES[1] / FREQUENCIES[0]
"""Lift of the axle boxes in roll, by which both suspensions have one stiffness."""
SUSPENSION = np.array([[1.0, 1.0], [BOX, -BOX], [0.0, 0.0], [0.0, 0.0]])
MIDDLE = np.array([1.0, 0.0, -1.0, 0.0])
"""Lift of the middle of the axle, a measuring point."""
OF_MODES = np.array([0.9, 0.9, 0.08, 0.08])
"""Share of each mode in the static stress under equal or opposite loads."""
STATIC = {"A1": (430.0, 240.0), "B1": (330.0, 310.0), "C1": (215.0, 390.0)}
"""Longitudinal stress at the top of the axle by 1 N on wheel 1 and on wheel 2, Pa."""
POSITIONS = {"A1": -0.55, "B1": 0.0, "C1": 0.55}
"""Of the stress nodes along the axle, m."""
COMPONENTS = np.array([0.05, 1.0, 0.02, 0.0, 0.0, -0.1])
"""Stress components xx, yy, zz, xy, xz, yz as shares of yy."""


def toy_wheelset() -> dict[str, Any]:
    """The wheelset as a scenario holds it."""
    stiffness = MODAL_MASSES * (2 * np.pi * FREQUENCIES) ** 2
    nodes = []
    for name, (first, second) in STATIC.items():
        modal = OF_MODES * stiffness / 2 * (LIFT @ [first, second])
        nodes.append(
            {
                "name": name,
                "position": [0.0, POSITIONS[name], 0.09],
                "diameter": 0.18,
                "modal": np.outer(modal, COMPONENTS).tolist(),
                "static": np.outer([first, second], COMPONENTS).tolist(),
            }
        )
    return {
        "imported": 1,
        "name": "toy",
        "mass": float(MODAL_MASSES[0]),
        "rolling_radius": 0.4318,
        "modes": {
            "frequencies": FREQUENCIES.tolist(),
            "damping_ratios": DAMPING_RATIOS.tolist(),
            "modal_masses": MODAL_MASSES.tolist(),
            "lift": LIFT.tolist(),
            "suspension": SUSPENSION.tolist(),
        },
        "measuring_points": [{"name": "middle", "modal_lift": MIDDLE.tolist()}],
        "stress_nodes": nodes,
        "torque_places": [{"name": "gearbox", "y": 0.4}],
    }


def toy_half(places: int, ballast: float) -> HalfTrack:
    """Half a track with ``places`` steps a bay on a ``ballast`` stiffness, N/m, a sleeper."""
    rail, sleeper, pad = 50.0, 500.0, 3e8  # kg, kg, N/m
    stiffness = np.array([[pad, -pad], [-pad, pad + ballast]])
    damping = np.array([[1e5, -1e5], [-1e5, 1e5 + 1.5e5]])
    masses = np.array([[rail], [sleeper]])
    shape = 1 - 0.007 * np.cos(2 * np.pi * np.arange(places) / places)
    none = np.zeros((places, 1))
    return HalfTrack(
        rate=np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness / masses, -damping / masses]]),
        rate_of_speed=np.zeros((4, 4)),
        input=np.hstack([none, none, shape[:, None] / rail, none]),
        output=np.hstack([shape[:, None], none, none, none]),
        residual=np.full(places, 3e-10),
    )


def toy_scenario(*changes: str, like: str = "undamaged", sensors: Sequence[Any] = ()) -> Scenario:
    """A shipped scenario with the toy wheelset, and ``changes`` as on the command line."""
    sensed = {"wheelset": toy_wheelset(), "sensors": sensors}
    return scenario_from({**load_scenario(like, changes).to_mapping(), **sensed})


@cache
def toy_models(sensors: tuple[Any, ...] = ()) -> Models:
    """The models of all toy simulators: the toy track is in the place of that of the scenario."""
    scenario = toy_scenario()
    reduced = reduce_wheelset(scenario.wheelset, rows=rows_of(sensors))
    places = round(scenario.track.spacing / scenario.step_length)
    moving = MovingTrack(toy_half(places, 1.3e8), toy_half(places, 1.2e8))
    return Models(
        wheelset=scenario.wheelset,
        reduced=reduced,
        track=scenario.track,
        dynamics=causal_model(reduced, moving, scenario.output.stress_nodes, scenario.at_lag_zero),
        geometry=scenario.geometry,
        step_length=scenario.step_length,
        steps_per_revolution=scenario.steps_per_revolution,
        tread_origin=scenario.tread_origin,
    )


def toy_simulator(*changes: str, like: str = "undamaged", sensors: Sequence[Any] = ()) -> Simulator:
    """A simulator of a toy scenario on the toy track."""
    scenario = toy_scenario(*changes, like=like, sensors=sensors)
    return Simulator(scenario, models=toy_models(scenario.sensors))
