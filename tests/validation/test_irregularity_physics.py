"""Irregularities in motion, against closed forms and against the linear response of wheelset, track and contact."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.contact import ContactGeometry, approach_for_force, build_contact_law, solve_patch
from wheelset_track_sim.contact.law_kernels import total_separation
from wheelset_track_sim.irregularities import (
    Breakout,
    Corrugation,
    DippedWeld,
    Flat,
    Harmonic,
    HeadDefect,
    Joint,
    Polygon,
    Squat,
)
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.bloch import receptance

pytestmark = pytest.mark.slow

N_C, DX = 2713, 1e-3
GEOMETRY = ContactGeometry(wheel_radius=N_C * DX / (2 * np.pi))
STATIC = 98.1e3


@pytest.mark.parametrize("length", [0.030, 0.060, 0.100])
def test_a_wheel_rolls_over_the_edges_of_a_fresh_flat(length):
    """Rigid wheel: within L/2 of the middle it turns about an edge of the chord and sinks by (L/2 - |u|)^2 / (2 R)."""
    law = build_contact_law([Flat("wheel_1", length)], GEOMETRY, DX, N_C, tables=False)
    u = np.arange(-60, 61)
    sinks = np.array([total_separation(law, 0, int(step), 0).min() for step in u])
    radius = GEOMETRY.wheel_radius
    expected = np.maximum(length / 2 - np.abs(u) * DX, 0.0) ** 2 / (2 * radius)
    depth = length**2 / (8 * radius)
    # The edge lies up to half a step beside the middle of an element: as far as the wheel's path there is inclined.
    assert np.abs(sinks - expected).max() < DX * length / (2 * radius)
    assert sinks[60] == pytest.approx(depth, rel=0.02)
    assert np.abs(sinks - sinks[::-1]).max() == 0.0


def test_a_loaded_wheel_follows_the_path_of_the_rigid_one_over_a_rounded_flat():
    """Quasi-static: under a constant force the approach changes by the path, here the height under the wheel."""
    flat = Flat("wheel_1", 0.040, worn_length=0.300)
    law = build_contact_law([flat], GEOMETRY, DX, N_C, tables=False)
    smooth = approach_for_force(law, 0, N_C // 2, 0, STATIC)
    u = np.arange(-200, 201, 10)
    path = np.array([approach_for_force(law, 0, int(step), 0, STATIC) for step in u]) - smooth
    heights = flat.height(u * DX, GEOMETRY.wheel_radius)
    # A slope h' moves the point of contact by R h', where the wheel is nearer to the rail by R h'^2 / 2.
    slope = np.gradient(heights, u * DX)
    assert path == pytest.approx(-heights - GEOMETRY.wheel_radius * slope**2 / 2, abs=4e-6)
    assert path.max() == pytest.approx(flat.depth(GEOMETRY.wheel_radius), rel=0.03)


def linear_forces(models, frequency, height):
    """(1/k_H + H_w + H_r) F = h: complex force amplitudes of both wheels for those of their irregularities."""
    wheels = models.reduced.receptance(np.array([frequency]))[0]
    direct, cross = (
        np.mean([receptance(models.track, [frequency], x, [x])[part].ravel()[0] for x in np.arange(12) * 0.05])
        for part in (0, 1)
    )
    law = models.contact_law(())
    k = solve_patch(law, 0, 0, 0, approach_for_force(law, 0, 0, 0, STATIC)).stiffness
    compliance = wheels + np.array([[direct, cross], [cross, direct]]) + np.eye(2) / k
    return np.linalg.solve(compliance, np.asarray(height, complex))


def response(irregularities, period, turns, **changes):
    """Complex amplitudes of both forces at a wave that passes in ``period`` steps, smooth running taken off."""
    scenario = dataclasses.replace(load_scenario("undamaged"), **changes)
    models = load_models(scenario, tables="smooth")
    steps, skipped = round(turns * period), 6000
    found = []
    for shapes in ((), irregularities):
        simulator = Simulator(dataclasses.replace(scenario, irregularities=shapes), models=models)
        forces = [simulator.advance(2000).forces for _ in range((skipped + steps) // 2000 + 1)]
        found.append(np.concatenate(forces)[skipped : skipped + steps])
    wave = np.exp(-2j * np.pi * (skipped + np.arange(steps) - 1) / period)
    return models, 2 / steps * (wave @ (found[1] - found[0]))


@pytest.mark.parametrize("order", [3, 10, 24])
def test_a_polygon_answers_as_the_receptances_say(order):
    """At f = n v / (2 pi R): 31, 102 and 246 Hz, small waves on wheel 1."""
    polygon = Polygon("wheel_1", (Harmonic(order, 2e-6),))
    models, found = response((polygon,), N_C / order, 8 * order)
    expected = linear_forces(models, order * 27.7777778 / (N_C * DX), [2e-6, 0.0])
    assert abs(found[0]) == pytest.approx(abs(expected[0]), rel=0.04)
    assert abs(found[1] - expected[1] * found[0] / expected[0]) < 0.05 * abs(expected[0])


def test_corrugation_answers_as_the_receptances_say():
    """Waves of 0.25 m on rail 1 pass at 111 Hz; the phase is right, too: a crest is under the wheel at each period."""
    waves = Corrugation("rail_1", wavelength=0.25, amplitude=2e-6)
    models, found = response((waves,), 250, 80, line_length=6.0)
    expected = linear_forces(models, 27.7777778 / 0.25, [2e-6, 0.0])
    assert abs(found[0]) == pytest.approx(abs(expected[0]), rel=0.04)
    assert np.angle(found[0] / expected[0]) == pytest.approx(0.0, abs=0.1)
    assert abs(found[1] - expected[1]) < 0.05 * abs(expected[0])


NOTHING = (
    Breakout("wheel_1", 0.03, 0.024, 0.0),
    Polygon("wheel_2", (Harmonic(3, 0.0), Harmonic(7, 0.0, phase=1.0))),
    Corrugation("rail_1", wavelength=0.04, amplitude=0.0),
    Squat("rail_1", 2.0, 0.02, 0.01, 0.0),
    HeadDefect("rail_2", 2.0, 0.02, 0.01, 0.0, y=0.01),
    Joint("rail_2", 3.0, dip_angle=0.0, gap=0.0),
    DippedWeld("rail_1", 4.0, depth=0.0),
)


def test_any_number_of_irregularities_without_height_changes_no_bit():
    bare, nothing = (Simulator(load_scenario("undamaged")) for _ in range(2))
    models = nothing.models
    still = dataclasses.replace(nothing.scenario, irregularities=NOTHING * 20, settle_on="smooth")
    first = bare.advance(1000)
    again = Simulator(still, models=models).advance(1000)
    assert (again.forces == first.forces).all()
    assert (again.stresses == first.stresses).all()


@pytest.mark.parametrize("tables", [True, False])
def test_what_is_mirrored_left_to_right_bears_the_same(tables):
    shapes = (
        Breakout("wheel_1", 0.020, 0.012, 0.0008, angle=0.4, y=0.006),
        Squat("rail_1", 1.0, 0.020, 0.010, 0.0005, y=-0.004),
        Flat("wheel_2", 0.030, angle=2.0),
        DippedWeld("rail_2", 2.0, depth=0.0004),
    )
    other = {"wheel_1": "wheel_2", "wheel_2": "wheel_1", "rail_1": "rail_2", "rail_2": "rail_1"}
    mirrored = [
        dataclasses.replace(each, on=other[each.on], **({"y": -each.y} if hasattr(each, "y") else {}))
        for each in shapes
    ]
    one, two = (
        build_contact_law(each, GEOMETRY, DX, N_C, rail_steps=6000, tables=tables) for each in (shapes, mirrored)
    )
    places = [(0, round(0.4 / (2 * np.pi) * N_C) + 3, 0), (0, 2000, 1004), (1, 864, 0), (1, 2000, 1950), (1, 50, 50)]
    for wheel, tread, rail in places:
        for force in (1e3, 98.1e3, 250e3):
            approach = approach_for_force(one, wheel, tread, rail, force)
            assert approach_for_force(two, 1 - wheel, tread, rail, force) == pytest.approx(approach, abs=1e-12)
