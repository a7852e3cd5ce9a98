from itertools import pairwise

import numpy as np
import pytest

from wheelset_track_sim.dynamics.line import LineModel
from wheelset_track_sim.dynamics.line_bay_kernels import (
    COLUMNS,
    MIDDLE,
    NODES,
    RAIL,
    RAIL_MODES,
    ROWS,
    STATES,
    A,
    LineParts,
    R,
    U,
    V,
    advance_rails,
)
from wheelset_track_sim.dynamics.line_kernels import Bays, move
from wheelset_track_sim.dynamics.line_steps import RESOLVED, SHORT
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.simulation.models import load_models

DX, STATIC = 1e-3, 98.1e3


NOTHING = LineParts(
    bend=0.0,
    shear=np.zeros(3),
    coupling=np.zeros((2, RAIL_MODES)),
    nodes=np.zeros((0, 0)),
    shares=np.zeros((2, 0)),
    turn=0.0,
    losses=np.zeros(2 * COLUMNS),
    shapes=np.zeros((1, 6 + 2 * RAIL_MODES)),
)


def turned(omega: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Deflections (steps, modes) of oscillators that begin at 1 and at rest, in steps of ``periods`` s, as nodes do."""
    W = np.zeros(4 * COLUMNS)
    W[: len(omega)] = omega
    motion = np.zeros(ROWS * COLUMNS)
    u, v, a = (motion[row * COLUMNS : (row + 4) * COLUMNS] for row in (U, V, A))
    dt = periods[0]
    u[:], v[:], found = 1 - 5 / 12 * (dt * W) ** 2, -dt / 2 * W**2, [np.ones(len(omega))]
    for now, coming in pairwise(periods):
        a[:] = -(W**2) * u / (1 + (now * W) ** 2 / 12)
        found.append((u + now**2 / 12 * a)[: len(omega)])
        advance_rails(NOTHING, np.zeros(RAIL_MODES), np.ones(RAIL_MODES), now, coming, motion)
    return np.array(found)


def test_the_period_errs_by_the_fourth_power_of_the_step() -> None:
    W = np.array([0.2, 0.4, 0.8])
    found = turned(W, np.ones(2000))
    theta = W * (1 + W**4 / 480)
    assert found == pytest.approx(np.cos(np.outer(np.arange(2000), theta)), abs=0.1)
    assert np.abs(found[-1] - np.cos(1999 * W))[2] > 0.5  # the oscillator itself is elsewhere by then
    assert np.abs(found).max() < 1 + 1e-9


def test_the_step_is_stable_up_to_the_root_of_six() -> None:
    found = np.abs(turned(np.sqrt([5.9, 5.999, 6.01]), np.ones(2000))).max(axis=0)
    assert found[:2].max() < 1.01
    assert found[2] > 1e6


def test_a_step_of_another_length_goes_on_with_the_motion() -> None:
    """With W = omega dt, phases err by W^4/480; velocities are too small by W^2/12, which a change of dt changes."""
    omega, periods = np.array([0.025, 0.05, 0.1, 0.2]), np.repeat([1.0, 1.5], 300)
    time = np.concatenate([[0.0], np.cumsum(periods[:-1])])
    phase = (omega[:, np.newaxis] * periods) ** 4 / 480 * omega[:, np.newaxis] * periods
    bound = (1.5**2 - 1.0) * omega**2 / 12 + phase.sum(axis=1)
    assert (np.abs(turned(omega, periods) - np.cos(np.outer(time, omega))).max(axis=0) < bound).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "speed"), [("ballasted_60e1", 27.7777778), ("slab_60e1", 27.7777778), ("ballasted_60e1", 5.5)]
)
def test_a_step_is_newmarks_with_the_whole_matrices(base: str, speed: float) -> None:
    scatter = {"pad_stiffness": 0.2, "pad_damping": 0.2} | ({} if base == "slab_60e1" else {"ballast_stiffness": 0.3})
    scenario = scenario_from(
        {**load_scenario("undamaged").to_mapping(), "track": {"base": base, "line": {"bays": 60, "scatter": scatter}}}
    )
    model = load_models(scenario).dynamics
    assert isinstance(model, LineModel)
    line, dt = model.line, DX / speed
    step, random = 7300, np.random.default_rng(0)
    bays = model.start(STATIC, step, DX, speed).bays
    for _ in range(40):
        step = move(bays, step + 1, *(STATIC * random.uniform(0.5, 1.5, 2)))

    count, n, m = 60, line.size, RAIL_MODES
    M, C, K = (matrix.toarray() for matrix in line.matrices(bays.at[0] - MIDDLE, count))
    inertia = bays.steps.inertia
    raised = np.maximum(1.0, line.span.modes * (dt / RESOLVED) ** 2 / min(1.0, SHORT / dt))
    kappa = ((inertia - raised) / line.span.modes)[0]
    assert (kappa > 1.01 * dt**2 / 12) == (raised > 1.0).any() == (speed < 10.0)
    modes = (np.arange(count)[:, None] * n + 4 + np.arange(2 * m)).ravel()
    M[modes, modes] += np.tile(raised - 1.0, 2 * count)

    def predictor(bays: Bays) -> tuple[np.ndarray, np.ndarray]:
        """u* and v* (count, n) of all bays."""
        rows, u, v = bays.motion.reshape(ROWS, COLUMNS), np.zeros((count, n)), np.zeros((count, n))
        u[:NODES, :RAIL], v[:NODES, :RAIL] = rows[U : U + RAIL, :NODES].T, rows[V : V + RAIL, :NODES].T
        if n > RAIL:
            around = (bays.at[0] - MIDDLE + np.arange(NODES)) % count
            x = np.einsum("bij,jb->bi", bays.steps.shapes[around], rows[R : R + STATES, :NODES])
            u[:NODES, RAIL:], v[:NODES, RAIL:] = x[:, : n - RAIL], x[:, n - RAIL :] / dt
        return u, v

    dampers = np.zeros((count, n))
    dampers[:NODES, :4] = bays.parts.losses.reshape(2, COLUMNS)[[0, 1, 0, 1], :NODES].T
    deflection, velocity = predictor(bays)
    load = -K @ deflection.ravel() - C @ velocity.ravel() - (dampers * velocity).ravel()
    places = len(bays.parts.shapes)
    place = step + places // 2 - bays.at[0] * places
    shape = bays.parts.shapes[place]
    forces, pushed = np.array([9e4, 1.2e5]), np.zeros((count, n))
    for rail in range(2):
        for i in range(6):
            pushed[MIDDLE - 1 + i // 2, 2 * rail + i % 2] += shape[i] * forces[rail]
        for i in range(2 * m):
            pushed[MIDDLE - 1 + i // m, 4 + m * rail + i % m] += shape[6 + i] * forces[rail]
    expected = np.linalg.solve(M + dt / 2 * C + kappa * K, load + pushed.ravel()).reshape(count, n)

    coming, compliance = bays.coming[1].copy(), bays.rail_compliance[0]
    residual = bays.steps.own[place] - dt**2 / 12 * (shape[6:] ** 2 / np.tile(inertia, 2)).sum()
    at_step = deflection + dt**2 / 12 * expected
    move(bays, step + 1, *forces)
    near = slice(MIDDLE - 12, MIDDLE + 13)  # the chain of the bays ends, the ring of the matrices does not
    found = (predictor(bays)[1] - velocity) / dt
    assert np.abs(found - expected)[near].max() < 1e-9 * np.abs(expected).max()
    for rail in range(2):
        ends = at_step[MIDDLE - 1 : MIDDLE + 2, 2 * rail : 2 * rail + 2].ravel()
        inside = at_step[MIDDLE - 1 : MIDDLE + 1, 4 + m * rail : 4 + m * (rail + 1)].ravel()
        deflection = shape @ np.concatenate([ends, inside]) + residual * forces[rail]
        # the compliance is the mean of both rails, whose supports differ
        assert coming[rail] + compliance * forces[rail] == pytest.approx(deflection, abs=0.01 * compliance * STATIC)
