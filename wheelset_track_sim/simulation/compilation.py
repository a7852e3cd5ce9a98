"""The kernels of a run, compiled before they are called: ``runtime.jit`` executes this module in a second process."""

from __future__ import annotations

import numpy as np

from ..contact.geometry import ContactGeometry
from ..contact.ordered.nested import no_nested_contacts
from ..dynamics.causal import causal_model
from ..runtime.jit import mark_compiled
from ..samples.block import SampleBlock
from ..samples.summary import summarise
from ..scenario import load_scenario
from ..track.balance import HalfTrack, MovingTrack
from ..wheelset.reduced import ReducedWheelset
from .changes import Condition, Revision
from .coupled import Coupled
from .models import Models


def compile_kernels() -> None:
    """Compile the kernels of a run: take a step of a system of two modes, for the compiler looks at types alone."""
    scenario = load_scenario("undamaged")
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
    models = Models(
        wheelset=scenario.wheelset,
        reduced=two_modes,
        track=scenario.track,
        dynamics=causal_model(two_modes, MovingTrack(half, half), nodes, scenario.at_lag_zero),
        geometry=ContactGeometry(wheel_radius=two_modes.rolling_radius),
        step_length=scenario.step_length,
        steps_per_revolution=1000,
        tread_origin=0,
        tables=False,
    )
    # One table will do: kernels that build tables or solve contacts are compiled by who needs them.
    law = models.contact_law(())
    law = law._replace(
        table=np.zeros((2, 1000), np.int32),
        rail_table=np.zeros_like(law.rail_table),
        smooth_tables=1,
        first_point=np.array([0, 2]),
        points=np.array([[0.0, 0.0], [1.0, 1e9]]),
        nested=(no_nested_contacts(), no_nested_contacts()),
    )
    forces, _ = Coupled(models, 0.0, 0, scenario.speed).run(
        Condition(Revision(0, 0), scenario, law, np.zeros(2), 0, 0), scenario.speed, np.zeros((1, 2))
    )
    summarise(SampleBlock(0, 0.0, 1.0, 1.0, 0.0, 0, forces, np.ones((1, len(nodes), 6)), nodes))
    mark_compiled()


if __name__ == "__main__":
    compile_kernels()
