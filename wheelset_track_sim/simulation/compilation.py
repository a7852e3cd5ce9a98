"""The kernels of a run, compiled before they are called: ``runtime.jit`` executes this module in a second process."""

from __future__ import annotations

import sys

import numpy as np

from ..contact.geometry import ContactGeometry
from ..contact.law_kernels import ContactLaw
from ..contact.ordered.nested import no_nested_contacts
from ..dynamics.causal import causal_model
from ..dynamics.interface import DynamicsModel
from ..dynamics.line import line_model
from ..dynamics.running_wheelset import running_wheelset
from ..irregularities import Flat, Roughness
from ..runtime.jit import compiled
from ..samples.block import SampleBlock
from ..samples.summary import summarise
from ..scenario import Scenario, load_scenario
from ..track.balance import HalfTrack, MovingTrack
from ..track.line import track_line
from ..wheelset.reduced import ReducedWheelset
from .changes import Condition, Revision
from .coupled import Coupled
from .models import Models


def compile_kernels(kernels: str) -> None:
    """Compile a set of kernels: step a system of two modes, for the compiler looks at types alone.

    Sets are ``causal`` and ``line``, steps of smooth wheels in these dynamics, and ``causal-changes`` and
    ``line-changes``, what steps with any irregularities need besides.
    """
    dynamics, _, changes = kernels.partition("-")
    settings = ["track={base: ballasted_60e1, line: {bays: 48}}"] if dynamics == "line" else []
    scenario = load_scenario("undamaged", settings)
    models = _models(scenario, tables=changes != "")
    coupled = Coupled(models, 0.0, 0, scenario.speed)
    if changes:
        models.contact_law((Flat("wheel_1", length=0.02),))
        coupled.prepare(models.contact_law((Roughness("wheel_1"),)))
        return
    condition = Condition(Revision(0, 0), scenario, _one_table(models.contact_law(())), np.zeros(2), 0, 0)
    forces, _ = coupled.run(condition, scenario.speed, np.zeros((1, 2)))
    nodes = scenario.output.stress_nodes
    summarise(SampleBlock(0, 0.0, 1.0, 1.0, 0.0, 0, forces, np.ones((1, len(nodes), 6)), nodes))


def _models(scenario: Scenario, *, tables: bool) -> Models:
    """Models of a wheelset of two modes, and of a track of as many or a line."""
    nodes = scenario.output.stress_nodes
    two_modes = ReducedWheelset(
        poles=np.array([-1 + 50j, -1 + 90j]),
        inputs=np.ones((2, 2), np.complex128),
        outputs=np.ones((2, 2), np.complex128),
        stress_outputs=np.ones((len(nodes), 6, 2), np.complex128),
        stress_feedthrough=np.ones((len(nodes), 6, 2)),
        displacement_residual=np.zeros((2, 2)),
        node_names=nodes,
        node_positions=np.zeros((len(nodes), 3)),
        mass=1.0,
        rolling_radius=0.4,
    )
    places = round(scenario.track.spacing / scenario.step_length)
    half = HalfTrack(
        rate=np.array([[-1.0, 50.0], [-50.0, -1.0]]),
        rate_of_speed=np.array([[0.0, 1.0], [-1.0, 0.0]]),
        input=np.ones((places, 2)),
        output=np.ones((places, 2)),
        residual=np.zeros(places),
    )
    lag_zero = scenario.at_lag_zero
    dynamics: DynamicsModel = causal_model(two_modes, MovingTrack(half, half), nodes, lag_zero)
    if scenario.track.line is not None:
        dynamics = line_model(running_wheelset(two_modes, nodes, lag_zero), track_line(scenario.track), lag_zero)
    return Models(
        wheelset=scenario.wheelset,
        reduced=two_modes,
        track=scenario.track,
        dynamics=dynamics,
        geometry=ContactGeometry(wheel_radius=two_modes.rolling_radius),
        step_length=scenario.step_length,
        steps_per_revolution=1000,
        tread_origin=0,
        tables=tables,
        tolerance=scenario.contact.largest_estimate,
    )


def _one_table(law: ContactLaw) -> ContactLaw:
    """A law with one table and nothing to solve: other kernels are compiled by who needs them."""
    return law._replace(
        table=np.zeros((2, 1000), np.int32),
        rail_table=np.zeros_like(law.rail_table),
        smooth_tables=1,
        first_point=np.array([0, 2]),
        points=np.array([[0.0, 0.0], [1.0, 1e9]]),
        nested=(no_nested_contacts(), no_nested_contacts()),
    )


if __name__ == "__main__":
    compile_kernels(sys.argv[1])
    compiled(sys.argv[1]).touch()
