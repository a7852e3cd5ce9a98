"""The contact filter against the solver: single contacts of all kinds, and every shipped scenario that uses it."""

from typing import NamedTuple

import numpy as np
import pytest

from support.advancing import advance_to
from wheelset_track_sim.contact import ContactGeometry, approach_for_force, build_contact_law
from wheelset_track_sim.contact.active_set_kernels import CONVERGED
from wheelset_track_sim.contact.law_kernels import ContactLaw, solve_contact
from wheelset_track_sim.contact.ordered.hinge_kernels import FILTERED, filtered_force
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.irregularities import Breakout, Irregularity, Roughness
from wheelset_track_sim.runtime.jit import kernel
from wheelset_track_sim.samples.block import NO_CONTACTS
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

DX, N_C, N_R = 0.001, 2713, 3000
STATIC = 98.1e3  # N
TOLERANCE = 0.001  # the default


class Compared(NamedTuple):
    """Contacts that were both solved and filtered, N; those that the filter leaves to the solver have no error."""

    force: np.ndarray
    error: np.ndarray
    estimate: np.ndarray
    filtered: np.ndarray


def law_of(*shapes: Irregularity) -> ContactLaw:
    return build_contact_law(shapes, ContactGeometry(), DX, N_C, rail_steps=N_R, filtered=True)


@kernel
def both(law, steps, approaches, compliance, bound, found):
    """Fill force, error, estimate and whether it is filtered, (n, 4), for one contact after the other."""
    none, guess = np.empty((0, 0)), np.zeros(law.separation.shape[1:], np.bool_)
    for n in range(len(steps)):
        step, approach = steps[n], approaches[n]
        exact, _, status = solve_contact(law, 0, step, step, approach, compliance, guess, none)
        force, estimate, how = filtered_force(
            law.hinges,
            0,
            law.separation.shape[1:],
            law.tread[0],
            law.rail_row[0],
            law.rail,
            step,
            step,
            law.element_area,
            approach,
            compliance,
            bound,
        )
        found[n, 0] = exact if status == CONVERGED else np.nan
        found[n, 1] = force - exact if how == FILTERED else 0.0
        found[n, 2] = estimate
        found[n, 3] = how == FILTERED


def compared(law: ContactLaw, steps: np.ndarray, load: float, bound: float = TOLERANCE * STATIC) -> Compared:
    """Contacts at ``steps``, with the approach that bears ``load``."""
    approaches = np.array([approach_for_force(law, 0, int(step), int(step), load, 1e-10) for step in steps])
    found = np.empty((len(steps), 4))
    both(law, steps, approaches, 1e-10, bound, found)
    found = found[np.isfinite(found[:, 0])]
    return Compared(found[:, 0], np.abs(found[:, 1]), found[:, 2], found[:, 3] > 0)


@pytest.fixture(scope="module", params=[-10.0, 0.0, 6.0], ids="{:+.0f} dB".format)
def rough(request):
    """Roughness on tread and rail, so many dB above the limit of ISO 3095, and its level."""
    return request.param, law_of(
        *(Roughness(on, seed=n, level=request.param) for n, on in ((1, "wheel_1"), (11, "rail_1")))
    )


@pytest.mark.slow
@pytest.mark.parametrize("load", [20e3, 50e3, 98.1e3, 200e3, 350e3])
def test_rough_contacts(rough, load):
    """No error is above 0.2 % of the static load of 20 t an axle, and its RMS is below 0.03 %."""
    level, law = rough
    steps = np.random.default_rng(int(load)).integers(0, N_C, 200)
    found = compared(law, steps, load)
    error, estimate = found.error[found.filtered], found.estimate[found.filtered]
    assert error.max() < 0.002 * STATIC
    assert np.sqrt(np.mean(error**2)) < 3e-4 * STATIC
    assert (error <= 10.0 * (estimate + 1.0)).all()
    assert (error <= estimate + 1.0).mean() > 0.85
    if level <= 0.0:
        assert found.filtered.mean() > (0.85 if load > 20e3 else 0.4)


@pytest.mark.slow
@pytest.mark.parametrize("level", [-60.0, 0.0])
@pytest.mark.parametrize(("a", "depth"), [(0.002, 1e-5), (0.002, 5e-5), (0.004, 1e-4), (0.008, 3e-5), (0.015, 2e-5)])
def test_defects_on_their_way_through_the_contact(a, depth, level):
    pit = Breakout("wheel_1", a, 0.8 * a, depth, angle=2 * np.pi * 1000 / N_C, y=0.002)
    law = law_of(pit, Roughness("rail_1", seed=4, level=level))
    for load in (50e3, 98.1e3, 250e3):
        found = compared(law, np.arange(985, 1016), load)
        assert (found.error < 0.005 * max(load, STATIC)).all()


SHIPPED = (
    "corrugation",
    "dipped_weld",
    "long_wave",
    "measured_tread",
    "mixed",
    "polygon",
    "rail_roughness",
    "rough_wheel",
)
"""Scenarios that have contacts without a table."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenarios(name):
    """A turn of the wheel: within 0.005 % RMS and 0.05 % maximum of the static load, and nearly everything filtered."""
    runs = []
    for exact in ("true", "false"):
        blocks = advance_to(Simulator(load_scenario(name, [f"contact.exact={exact}"])), 2900)
        runs.append(np.concatenate([block.forces for block in blocks]))
    counts = sum((block.contacts for block in blocks), NO_CONTACTS)
    error = np.abs(runs[0] - runs[1]) / load_scenario(name).wheel_load
    assert 0.0 < np.sqrt(np.mean(error**2, axis=0)).max() < 5e-5
    assert error.max() < 5e-4
    assert counts.filtered_steps > 0.9 * (counts.filtered_steps + counts.solved_steps)
    assert 0.0 < counts.largest_estimate <= TOLERANCE * load_scenario(name).wheel_load


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*shipped.names("scenarios")} - {*SHIPPED}))
def test_other_shipped_scenarios_have_nothing_to_filter(name):
    scenario = load_scenario(name)
    simulator = Simulator(scenario)
    assert (
        simulator.models.contact_law(scenario.irregularities, line_length=scenario.line_length).hinges.element.size == 0
    )
