"""A wheelset through CalculiX, from its geometry to a run, beside the harmonic elements."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tools.calculix_wheelset import as_yaml, by_calculix
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.wheelset.imported import ImportedWheelset
from wheelset_track_sim.wheelset.kinds import load_wheelset, reduce_wheelset
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.static_bending import own_weight_stress
from wheelset_track_sim.wheelset.wheelset import Wheelset

pytestmark = pytest.mark.slow
MODES = 10


@pytest.fixture(scope="module")
def trailer() -> Wheelset:
    trailer = load_wheelset("trailer")
    kept = tuple(node for node in trailer.stress_nodes if node.name in ("A1", "B2", "M"))
    return replace(trailer, stress_nodes=kept)


@pytest.fixture(scope="module")
def own(trailer: Wheelset) -> ReducedWheelset:
    return build_reduced_wheelset(trailer, max_frequency=500.0)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed: package calculix-ccx")
def test_from_geometry_to_a_run(trailer: Wheelset, own: ReducedWheelset, tmp_path: Path) -> None:
    path = tmp_path / "trailer_ccx.yaml"
    path.write_text(as_yaml(by_calculix(trailer, modes=MODES)), encoding="utf-8")
    imported = reduce_wheelset(load_wheelset(path))
    below = own.frequencies < 330.0
    assert imported.frequencies[: below.sum()] == pytest.approx(own.frequencies[below], rel=0.02)  # coarse bricks
    agree(imported, own)
    chosen = ["output.stress_nodes=[A1, M]", "irregularities=[]"]
    simulator = Simulator(load_scenario("trailer", [f"wheelset={path}", *chosen]))
    standard = Simulator(load_scenario("trailer", chosen))
    one, other = (run.advance(2000) for run in (simulator, standard))
    assert one.forces.mean() == pytest.approx(other.forces.mean(), rel=0.002)
    assert one.max_principal.mean(axis=0) == pytest.approx(other.max_principal.mean(axis=0), rel=0.04)


def agree(imported: ReducedWheelset, own: ReducedWheelset) -> None:
    """Static compliance within 1 %, bending stress within 3 %, and the same signs throughout."""
    compliance = [model.static_receptance() + model.displacement_residual for model in (imported, own)]
    assert compliance[0] == pytest.approx(compliance[1], rel=0.01)
    for name in ("A1", "B2", "M"):
        found, expected = (model.static_stress()[model.node(name)] for model in (imported, own))
        assert found == pytest.approx(expected, rel=0.03, abs=0.05 * np.abs(expected).max())
        assert found[1] == pytest.approx(expected[1], rel=0.03)
        slow = np.array([2.0, 40.0])
        found, expected = (model.stress_receptance(slow)[:, model.node(name), 1] for model in (imported, own))
        assert found == pytest.approx(expected, abs=0.05 * np.abs(expected).max())


def test_the_shipped_file_is_the_trailers(own: ReducedWheelset) -> None:
    """Also where CalculiX is not installed."""
    shipped = reduce_wheelset(load_wheelset("trailer_calculix"))
    agree(shipped, own)
    assert shipped.mass == pytest.approx(own.mass, rel=1e-3)


def test_own_weight_is_the_same_in_both(trailer: Wheelset, own: ReducedWheelset) -> None:
    """Bricks under gravity beside the body force of n = 1, a node at a time."""
    imported = load_wheelset("trailer_calculix")
    assert isinstance(imported, ImportedWheelset)
    reduced = imported.reduced()
    found = imported.under_own_weight().cosine
    expected = own_weight_stress(trailer, own.node_positions[:, 1]).cosine
    for name, there in zip(own.node_names, expected, strict=True):
        assert found[reduced.node(name), 1] == pytest.approx(there[1], rel=0.03)


def test_a_program_that_is_not_there_is_named(trailer: Wheelset) -> None:
    with pytest.raises(InputError, match=r"ccx_of_nowhere cannot be run .* install calculix-ccx"):
        by_calculix(trailer, ccx="ccx_of_nowhere")
