"""Single contact problems against tamaas and ContactMechanics, on equal grids, and how each grows with the grid."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.conftest import Measure, group
from benchmarks.half_spaces import SOLVERS, Problem, sphere, wheel_on_rail
from wheelset_track_sim.contact.solutions import force_at
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models

EDGE = Breakout("wheel_1", 0.030, 0.024, 0.002)
PROBLEMS = {
    "wheel on rail, 120 kN": lambda: wheel_on_rail(1e-3, 0.75e-3, 1.2e-4, None, 0),
    "edge of a defect, 200 kN": lambda: wheel_on_rail(1e-3, 0.75e-3, 2.0e-4, EDGE, 22),
    "sphere (Hertz), 290 kN": lambda: sphere(1e-3, 2.0e-4),
    "wheel on rail, 0.5 mm": lambda: wheel_on_rail(0.5e-3, 0.5e-3, 1.2e-4, None, 0),
    "wheel on rail, 0.25 mm": lambda: wheel_on_rail(0.25e-3, 0.25e-3, 1.2e-4, None, 0),
}


@pytest.fixture(scope="module", params=PROBLEMS)
def problem(request: pytest.FixtureRequest) -> tuple[str, Problem]:
    return request.param, PROBLEMS[request.param]()


@group("contact")
@pytest.mark.parametrize("solver", SOLVERS)
def test_half_space(measure: Measure, problem: tuple[str, Problem], solver: str) -> None:
    name, posed = problem
    if solver != "this package":
        pytest.importorskip(solver)
    solve = SOLVERS[solver](posed)
    error = np.abs(solve() - posed.pressure).max() / posed.pressure.max()
    assert error < 1e-6
    grid = "{} x {}".format(*posed.gap.shape)
    inside = int((posed.pressure > 0).sum())
    measure(solve, rounds=10, problem=name, solver=solver, grid=grid, inside=inside, error=float(error))


@group("contact")
@pytest.mark.parametrize("tables", [True, False], ids=["table", "solver"])
def test_contact_in_the_run(measure: Measure, tables: bool) -> None:
    """One contact at 98 kN as the coupled step asks for it, without the call: 1000 places, a guess from the last."""
    scenario = load_scenario("undamaged")
    law = load_models(scenario, tables=tables).contact_law(())
    approach = 1.05e-4 + 2e-7 * np.sin(np.arange(1000) / 7)
    force = contact_forces(law, approach)
    assert force.min() > 90e3
    assert force.max() < 110e3
    assert force[5] == force_at(law, 0, 5, 5, approach[5])
    measure(lambda: contact_forces(law, approach), rounds=20, contacts=len(approach))


def contact_forces(law: object, approach: np.ndarray) -> np.ndarray:
    from benchmarks.profile_kernels import forces

    found = np.empty(len(approach))
    forces(law, approach, found)
    return found
