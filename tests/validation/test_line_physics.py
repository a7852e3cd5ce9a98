"""The line of bays against finite elements with the same supports, and what hangs against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from support.line_elements import Elements
from wheelset_track_sim.dynamics.line import LineModel
from wheelset_track_sim.dynamics.line_kernels import Line, move
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.track.line import track_line
from wheelset_track_sim.track.supports import along
from wheelset_track_sim.track.track import Track, load_track

pytestmark = pytest.mark.slow

DX, SPEED = 1e-3, 100 / 3.6
DT = DX / SPEED
VARIED = {
    "supports": [
        {"sleepers": 30, "on": "rail_1", "pad_stiffness": 0.3, "pad_damping": 0.5},
        {"sleepers": "31-33", "on": "rail_2", "ballast_stiffness": 0.25, "ballast_damping": 2.0},
        {"sleepers": "36-79", "over": 2, "ballast_stiffness": 4.0},
    ],
    "scatter": {"pad_stiffness": 0.2, "ballast_stiffness": 0.3, "seed": 5},
}


def varied(base: str = "ballasted_60e1", **line: object) -> Track:
    return load_track({"base": base, "line": line})


def elements(track: Track, first: int = 10, bays: int = 44) -> Elements:
    assert track.line is not None
    return Elements(track, along(track.line), first, bays)


@pytest.fixture(scope="module")
def wheelset() -> LineModel:
    model = load_models(load_scenario("undamaged", ["track={base: ballasted_60e1, line: {}}"])).dynamics
    assert isinstance(model, LineModel)
    return model


def standing(model: LineModel, track: Track, step: int) -> tuple[LineModel, Line]:
    """Line of a track without load, with the wheels at a step."""
    own = replace(model, line=track_line(track))
    return own, own.start(0.0, step, DX, SPEED)


def moved(model: LineModel, track: Track, step: int, forces: np.ndarray, stay: bool = False) -> np.ndarray:
    """Deflections (steps, 2) of both rails under prescribed forces (steps, 2) that run from ``step``, or stay there."""
    _, line = standing(model, track, step)
    xi = np.zeros(forces.shape)
    for n, (one, two) in enumerate(forces):
        xi[n] = line.coming[1] + line.rail_compliance[0] * forces[n]
        move(line.bays, step if stay else step + n + 1, one, two)
    return xi


@pytest.mark.parametrize("place", [30 * 0.6, 31.5 * 0.6, 35.3 * 0.6])
def test_varied_supports_have_the_receptances_of_finite_elements(place: float) -> None:
    track = varied(**VARIED)
    frequencies = np.array([0.0, 20.0, 75.0, 163.0, 292.0, 500.0, 800.0, 1500.0, 2000.0])
    line, plain = track_line(track), elements(track)
    level = np.abs(plain.receptance(frequencies, (0, place), (0, place)))
    for load in range(2):
        for response in range(2):
            mine = line.receptance(frequencies, (load, place), (response, place))
            error = np.abs(mine - plain.receptance(frequencies, (load, place), (response, place))) / level
            assert error[frequencies < 300].max() < 2e-3
            assert error[frequencies < 1000].max() < 0.015
            assert error.max() < 0.07  # clamped ends, and modes of the rail that are left out


def pulses(steps: int) -> np.ndarray:
    """A pulse of 3 ms on rail 1 and a slower one on rail 2."""
    n = np.arange(steps)
    one = np.where(n < 84, np.sin(np.pi * n / 84) ** 2, 0.0)
    two = np.where(n < 300, np.sin(np.pi * n / 300) ** 2, 0.0)
    return 1e5 * np.stack([one, 0.7 * two], axis=1)


@pytest.mark.parametrize("line", [VARIED, {"supports": [{"sleepers": "31-32", "gap": 1e-4}]}, {}])
def test_moving_loads_deflect_the_rails_as_in_finite_elements(wheelset: LineModel, line: dict) -> None:
    track, forces = varied(**line), pulses(700)
    start = 30 * 600 + 450
    mine = moved(wheelset, track, start, forces)
    exact = elements(track, 20, 22).under_moving(forces, start * DX, DX, DT, 2)
    # 12 ms on, waves come back from the clamped ends of the finite elements
    assert np.abs(mine - exact)[:350].max() < 0.006 * exact.max()
    assert np.abs(mine - exact).max() < 0.02 * exact.max()


@pytest.mark.parametrize("frequency", [60.0, 180.0])
@pytest.mark.parametrize(("gap", "load"), [(0.02, 2e4), (0.0, 1e5)])
def test_a_hanging_sleeper_has_ballast_or_has_none(
    wheelset: LineModel, frequency: float, gap: float, load: float
) -> None:
    """A gap that never closes is no ballast at all; no gap, under a load, is the ordinary track. Below 200 Hz."""
    hangs = [{"sleepers": "30", "gap": gap}]
    steps = round(0.25 / DT)
    swell = np.minimum(1.0, np.arange(steps) * DT / 0.05)
    ripple = 0.05 * load * np.cos(2 * np.pi * frequency * DT * np.arange(steps))
    forces = np.repeat((swell * load + np.where(swell < 1.0, 0.0, ripple))[:, None], 2, axis=1)
    xi = moved(wheelset, varied(supports=hangs), 30 * 600, forces, stay=True)[:, 0]
    last = slice(steps - 4 * round(1 / frequency / DT), None)
    turning = np.exp(-2j * np.pi * frequency * DT * np.arange(steps))[last]
    measured = 2 * np.mean((xi[last] - xi[last].mean()) * turning) / (0.05 * load)
    track = varied(supports=hangs if gap else [])
    exact = sum(elements(track).receptance(np.array([frequency]), (0, 18.0), (rail, 18.0))[0] for rail in range(2))
    assert abs(measured - exact) < 0.01 * abs(exact)


def test_a_gap_closes_where_the_closed_form_says(wheelset: LineModel) -> None:
    """A stiff sleeper: its gap closes at one load; below it there is no ballast, above it that of the track."""
    base = load_track("ballasted_60e1")
    assert base.sleeper is not None
    stiff = replace(base, sleeper=replace(base.sleeper, youngs_modulus=1e12, moment_of_inertia=1e-1, area=0.3))
    open_, closed, gap = (
        replace(stiff, line=varied(supports=supports).line)
        for supports in ([{"sleepers": 30, "gap": 0.02}], [], [{"sleepers": 30, "gap": 2e-4}])
    )
    deflection = {}
    for name, track in (("open", open_), ("closed", closed)):
        plain = elements(track)
        force = plain.row(0, 18.0) + plain.row(1, 18.0)
        u = np.zeros(2 * plain.rail_size + (plain.bays + 1) * plain.per_sleeper)
        u[plain.free] = splu(plain.K).solve(force)
        sleeper = u[2 * plain.rail_size + 20 * plain.per_sleeper :][: plain.per_sleeper : 2]
        assert np.ptp(sleeper) < 1e-3 * sleeper.mean()
        deflection[name] = (plain.row(0, 18.0) @ u[plain.free], sleeper.mean())
    closes = 2e-4 / deflection["open"][1]
    steps = round(0.6 / DT)
    for load in (0.6 * closes, 2.0 * closes):
        forces = np.full((steps, 2), load) * np.minimum(1.0, np.arange(steps) * DT / 0.2)[:, None]
        xi = moved(wheelset, gap, 30 * 600, forces, stay=True)[-1, 0]
        expected = deflection["open"][0] * min(load, closes) + deflection["closed"][0] * max(load - closes, 0.0)
        assert xi == pytest.approx(expected, rel=2e-3)


def test_slow_loads_deflect_the_rails_of_a_transition_statically(wheelset: LineModel) -> None:
    track = varied(supports=[{"sleepers": "30-60", "over": 2, "ballast_stiffness": 8.0}])
    line = track_line(track)
    model = replace(wheelset, line=line)
    steps, first, load, speed = 6000, 24 * 600, 1e5, 5.0
    running = model.start(load, first, DX, speed)
    xi = np.zeros(steps)
    for n in range(steps):
        xi[n] = running.coming[1, 0] + running.rail_compliance[0] * load
        move(running.bays, first + n + 1, load, load)
    static = line.compliance((first + np.arange(0, steps, 50)) * DX)[:, 0] * load
    assert static.max() / static.min() > 1.5
    assert xi[::50] == pytest.approx(static, rel=0.015)


def test_a_mirrored_line_gives_mirrored_rails(wheelset: LineModel) -> None:
    forces = pulses(1500)
    found = []
    for one, two in (("rail_1", "rail_2"), ("rail_2", "rail_1")):
        supports = [
            {"sleepers": "30-31", "on": one, "ballast_stiffness": 0.3, "pad_damping": 2.0},
            {"sleepers": 31, "on": two, "gap": 2e-4},
        ]
        track = varied(supports=supports)
        found.append(moved(wheelset, track, 30 * 600, forces if one == "rail_1" else forces[:, ::-1]))
    assert found[1][:, ::-1] == pytest.approx(found[0], rel=1e-9, abs=1e-15)
    assert np.abs(found[0][:, 0] - found[0][:, 1]).max() > 1e-5
