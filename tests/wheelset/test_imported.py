"""Modes from elsewhere: what the file means, and what is refused."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.shipped import table_text
from wheelset_track_sim.inputs.yaml12 import dump
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.scenario.loads import LateralForces, Loads, PressFit
from wheelset_track_sim.simulation.superposition import superposition
from wheelset_track_sim.wheelset.harmonic_elements import nodal_stress
from wheelset_track_sim.wheelset.harmonics import HARMONICS, harmonic
from wheelset_track_sim.wheelset.imported import ImportedWheelset
from wheelset_track_sim.wheelset.kinds import load_wheelset, plain_wheelset, read_wheelset, with_geometry
from wheelset_track_sim.wheelset.mesh import wheelset_mesh
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.stress_points import around_axle
from wheelset_track_sim.wheelset.wheelset import Wheelset

BAND = 1500.0


@pytest.fixture(scope="module")
def coarse() -> Wheelset:
    x40 = load_wheelset("x40")
    return replace(x40, mesh=x40.mesh.divided(0.5))


@pytest.fixture(scope="module")
def reduced(coarse: Wheelset) -> ReducedWheelset:
    return build_reduced_wheelset(coarse, max_frequency=BAND)


@pytest.fixture(scope="module")
def content(coarse: Wheelset, reduced: ReducedWheelset) -> dict[str, Any]:
    """The X40 as another program would give it, from undamped modes; modal masses of 4 for a change."""
    mesh = wheelset_mesh(coarse)
    nodes = mesh.nodes_on(reduced.node_positions[:, 1:])
    parts = []
    for n in HARMONICS:
        model = harmonic(coarse, mesh, n)
        frequencies, modes = model.modes(BAND)
        stress = nodal_stress(mesh, coarse.material, n, nodes) @ model.free @ modes
        turned = np.einsum("ij,njm->mni", around_axle(n, 0.0), stress.reshape(len(nodes), 6, -1))
        parts.append((frequencies, modes.T @ model.contacts, modes.T @ model.boxes, turned))
    frequencies, lift, suspension, stress = (np.concatenate(part) for part in zip(*parts, strict=True))
    omega = 2 * np.pi * frequencies
    ratios = (coarse.material.mass_damping / omega + coarse.material.stiffness_damping * omega) / 2
    static = reduced.static_stress()
    return {
        "imported": 1,
        "name": "x40_again",
        "rolling_radius": 0.43175,
        "mass": reduced.mass,
        "contacts": [-0.75, 0.75],
        "suspension_damping": coarse.axle_boxes.damping,
        "static_lift": (reduced.static_receptance() + reduced.displacement_residual).tolist(),
        "modes": {
            "frequencies": frequencies.tolist(),
            "damping_ratios": ratios.tolist(),
            "modal_masses": [4.0] * len(omega),
            "lift": (2 * lift).tolist(),
            "suspension": (2 * suspension).tolist(),
        },
        "stress_nodes": [
            {
                "name": name,
                "position": reduced.node_positions[node].tolist(),
                "diameter": 0.18,
                "modal": (2 * stress[:, node]).tolist(),
                "static": static[node].T.tolist(),
            }
            for node, name in enumerate(reduced.node_names)
        ],
        "torque_places": [{"name": "gearbox", "y": 0.403}],
    }


def of(content: dict[str, Any]) -> ImportedWheelset:
    wheelset = load_wheelset(content)
    assert isinstance(wheelset, ImportedWheelset)
    return wheelset


def same(one: ReducedWheelset, other: ReducedWheelset) -> None:
    frequencies = np.array([0.0, 5.0, 80.0, 210.0, 1200.0])
    for response in ("receptance", "stress_receptance"):
        found, expected = getattr(one, response)(frequencies), getattr(other, response)(frequencies)
        assert found == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())


@pytest.mark.slow
def test_the_x40_by_its_modes_is_the_x40(content: dict[str, Any], reduced: ReducedWheelset) -> None:
    found = of(content).reduced()
    same(found, reduced)
    assert found.displacement_residual == pytest.approx(reduced.displacement_residual, abs=1e-12)
    assert (found.mass, found.rolling_radius, found.node_names) == (reduced.mass, 0.43175, reduced.node_names)


def test_poles_instead_of_frequencies(content: dict[str, Any], reduced: ReducedWheelset) -> None:
    modes = content["modes"]
    omega, ratios = 2 * np.pi * np.array(modes["frequencies"]), np.array(modes["damping_ratios"])
    poles = np.stack([-ratios * omega, omega * np.sqrt(1 - ratios**2)], axis=1)
    kept = {key: modes[key] for key in ("modal_masses", "lift", "suspension")}
    same(of({**content, "modes": {**kept, "poles": poles.tolist()}}).reduced(), reduced)


def test_yaml_text_tables_and_npz_are_one(content: dict[str, Any], tmp_path: Path) -> None:
    wheelset = of(content)
    tables = copy.deepcopy(content)
    arrays: dict[str, Any] = {key: value for key, value in content.items() if isinstance(value, (str, int, float))}
    arrays |= {key: np.array(content[key]) for key in ("contacts", "static_lift")}
    for key, values in content["modes"].items():
        tables["modes"][key] = table_text(np.array(values))
        arrays[f"modes.{key}"] = np.array(values)
    for index, node in enumerate(content["stress_nodes"]):
        arrays |= {f"stress_nodes.{index}.{key}": np.array(value) for key, value in node.items()}
    arrays |= {"torque_places.0.name": np.array("gearbox"), "torque_places.0.y": np.array(0.403)}
    (tmp_path / "mine.yaml").write_text(dump(tables), encoding="utf-8")
    np.savez(tmp_path / "mine.npz", **arrays)
    assert load_wheelset(tmp_path / "mine.yaml") == wheelset
    assert load_wheelset(tmp_path / "mine.npz") == wheelset
    # A scenario takes the file in, and needs it no more.
    for name in ("mine.yaml", "mine.npz"):
        scenario = load_scenario("undamaged", [f"wheelset={tmp_path / name}"])
        assert scenario.wheelset == wheelset
        assert scenario_from(scenario.to_mapping()) == scenario


def test_torque_by_diameters_and_places(content: dict[str, Any]) -> None:
    wheelset = of(content)
    found = superposition(Loads(torque=1000.0), wheelset, wheelset.reduced(), ("A1", "C1"))
    assert found is not None
    tau = 8 / (np.pi * 0.18**3)
    assert found.of_torque.at(found.angles)[:, 3] == pytest.approx([tau, -tau])


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        (Loads(press_fit=PressFit(wheels=1e-4)), "loads.press_fit needs the geometry .* is imported"),
        (Loads(lateral=LateralForces(wheel_1=1e4)), "loads.lateral needs the geometry .* x40_again is imported"),
        (Loads(horizontal_bending=True), "loads.horizontal_bending needs the geometry .* is imported: give its stress"),
        (Loads(torque=1.0, torque_at=("disc",)), "loads.torque_at.0 = 'disc' is not a known part .* gearbox, wheel_1"),
    ],
)
def test_loads_it_cannot_take_are_refused(content: dict[str, Any], loads: Loads, message: str) -> None:
    with pytest.raises(InputError, match=message):
        loads.check_against(of(content))


def test_own_weight_as_given(content: dict[str, Any]) -> None:
    """On the top and the bottom its bending counts; the shear, which the sides have, is not known there."""
    given = [-9e5, -5e6, -1e5, 0.0, 0.0, 7e5]
    with pytest.raises(InputError, match=r"stress_nodes.A1.own_weight is missing: .* or set loads.own_weight to false"):
        Loads(own_weight=True).check_against(of(content))
    whole = copy.deepcopy(content)
    for node in whole["stress_nodes"]:
        node["own_weight"] = given
    wheelset = of(whole)
    assert plain_wheelset(wheelset)["stress_nodes"][0]["own_weight"].split() == [*map(repr, given)]
    assert read_wheelset(plain_wheelset(wheelset), "wheelset") == wheelset
    loads = Loads(own_weight=True)
    loads.check_against(wheelset)
    found = superposition(loads, wheelset, wheelset.reduced(), ("A1", "C1"))
    assert found is not None
    assert pytest.approx(np.tile(given, (3, 2))) == found.stresses(np.zeros(3)).T
    assert found.constant.polar(np.array([0.0, np.pi]))[:, 1] == pytest.approx(np.tile([-5e6, 5e6], (2, 1)))


def test_no_diameter_no_torque(content: dict[str, Any]) -> None:
    spoiled = copy.deepcopy(content)
    del spoiled["stress_nodes"][1]["diameter"]
    with pytest.raises(InputError, match=r"stress_nodes.B1.diameter is missing"):
        Loads(torque=1.0).check_against(of(spoiled))


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("imported", 2, "imported = 2 is not a known version"),
        ("mass", -1.0, "mass = -1 kg is out of range"),
        ("modes.frequencies.0", 0.0, "modes.frequencies.0 = 0 Hz is out of range: give the natural frequency of the"),
        ("modes.damping_ratios.1", -0.1, "modes.damping_ratios.1 = -0.1 is out of range"),
        ("modes.lift.2", [1.0], "modes.lift.2 has 1 entries: give 2"),
        ("modes.frequencies", [100.0], "modes.frequencies has 1 entries: give"),
        ("modes.frequencies", [], "modes needs either poles, or frequencies with damping_ratios"),
        ("modes.suspension", [], "suspension_damping needs the modes' lift there"),
        ("modes.lift", "1 2\n3 x\n", "modes.lift is not a table of numbers"),
        ("modes.shapes", [], "modes.shapes is not a known key"),
        ("stress_nodes.0.modal", [[0.0] * 6], "stress_nodes.A1.modal has 1 entries: give"),
        ("stress_nodes.0.static.1", [0.0] * 5, "stress_nodes.A1.static.1 has 5 entries: give 6"),
        ("stress_nodes.0.own_weight", [0.0] * 3, "stress_nodes.A1.own_weight has 3 entries: give 6"),
        ("stress_nodes.0.position", [0.0, 0.0], "stress_nodes.A1.position has 2 entries: give 3"),
        ("stress_nodes.0.name", "A 1", "cannot name a topic"),
        ("stress_nodes.0.name", "b1", "give each a name of its own"),
        ("stress_nodes.0.diameter", 180.0, "diameter = 180 m is out of range"),
        ("torque_places.0.y", 403.0, "torque_places.0.y = 403 m is out of range"),
    ],
)
def test_bad_files_are_refused(content: dict[str, Any], path: str, value: Any, message: str) -> None:
    spoiled: Any = copy.deepcopy(content)
    *keys, last = path.split(".")
    place = spoiled
    for key in keys:
        place = place[int(key) if isinstance(place, list) else key]
    place[int(last) if isinstance(place, list) else last] = value
    with pytest.raises(InputError, match=message) as refusal:
        load_wheelset(spoiled)
    assert "\n" not in str(refusal.value)


def test_units_that_do_not_fit_are_noticed(content: dict[str, Any]) -> None:
    """Modal stress in MPa beside static stress in Pa."""
    spoiled = copy.deepcopy(content)
    node = spoiled["stress_nodes"][0]
    node["modal"] = (np.array(node["modal"]) / 1e6).tolist()
    with pytest.raises(InputError, match=r"stress_nodes.A1: the modes make .* Pa/N, static says .* give both in Pa"):
        of(spoiled).reduced()


def test_who_needs_geometry_says_so(content: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="x40_again is imported and has no geometry"):
        with_geometry(load_wheelset(content))


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.npz").write_bytes(b"PK no archive")
    with pytest.raises(InputError, match=r"mine.npz cannot be read"):
        load_wheelset(tmp_path / "mine.npz")
