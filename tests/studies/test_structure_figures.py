"""Figures of the structures: each writes its files, and its tables hold what is known of wheelset and track."""

import csv
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

from wheelset_track_sim.dynamics.causal import causal_model
from wheelset_track_sim.dynamics.causal_kernels import advance, displacements
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.report.figures import new_figure
from wheelset_track_sim.scenario import Output, Scenario, load_scenario
from wheelset_track_sim.studies import (
    drawing,
    moving_green_functions,
    track_receptances,
    wheelset_modes,
    wheelset_receptances,
)
from wheelset_track_sim.track.balance import moving_track
from wheelset_track_sim.track.ring import track_ring
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wheelset.kinds import load_wheelset, with_geometry
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import mode_shapes, reduced_wheelset

SCENARIO = load_scenario("undamaged")
FIGURES = {
    wheelset_receptances: (
        ["wheelset_receptances", "axle_stress_response", "wheelset_green_functions"],
        ["frequency (Hz)", "receptance (m/N)", "stress over force (Pa/N)", "phase (°)", "µm/(N s)", "time (s)"],
    ),
    wheelset_modes: (["wheelset_modes"], ["y (m)", "z (m)", "205.4 Hz, harmonic n = 1", "1912.0 Hz, harmonic n = 1"]),
    track_receptances: (
        ["track_receptances"],
        ["frequency (Hz)", "receptance (m/N)", "1073 Hz", "mid-bay"],
    ),
    moving_green_functions: (["moving_green_functions"], ["µm/(N s)", "time (ms)", "mid-bay, causal", "100 km/h"]),
}


class Drawn:
    """Files of all figures, drawn once, and the progress that was told."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.paths, self.progress = folder, {}, {}

    def __call__(self, module) -> list[Path]:
        if module not in self.paths:
            told = self.progress.setdefault(module, [])
            self.paths[module] = module.draw(self.folder, SCENARIO, lambda *stage: told.append(stage))
        return self.paths[module]

    def table(self, module, name: str) -> dict[str, np.ndarray]:
        assert self.folder / f"{name}.csv" in self(module)
        return read(self.folder / f"{name}.csv")


def read(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    columns = zip(head, zip(*rows, strict=True), strict=True)
    return {title: np.array(values, dtype=float if title.endswith(")") else str) for title, values in columns}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory) -> Drawn:
    return Drawn(tmp_path_factory.mktemp("figures"))


@pytest.fixture(scope="module")
def reduced() -> ReducedWheelset:
    return reduced_wheelset(with_geometry(SCENARIO.wheelset))


@pytest.mark.slow
@pytest.mark.parametrize("module", FIGURES, ids=lambda module: module.__name__.rpartition(".")[2])
def test_files_are_written_and_legible(module, drawn) -> None:
    paths, (names, texts) = drawn(module), FIGURES[module]
    assert len(set(paths)) == len(paths)
    assert all(path.stat().st_size > 100 for path in paths)
    written = ""
    for name in names:
        pixels = image.imread(drawn.folder / f"{name}.png")
        assert pixels.shape[1] == 1200
        assert np.unique(pixels.reshape(-1, 4), axis=0).shape[0] > 50  # curves, not an empty sheet
        tree = ET.parse(drawn.folder / f"{name}.svg")
        written += " ".join(text for text in tree.getroot().itertext() if text.strip())
        assert {drawn.folder / f"{name}.{kind}" for kind in ("png", "svg", "csv")} <= set(paths)
        assert all(title.rstrip().endswith(")") for title in read(drawn.folder / f"{name}.csv"))  # units
    for text in texts:
        assert text in written
    told = drawn.progress[module]
    assert all(isinstance(stage, str) and 0 <= fraction <= 1 for stage, fraction in told)


@pytest.mark.slow
def test_wheelset_stands_on_its_springs(drawn) -> None:
    """Statics of a rigid body on two springs, which the wheelset's own flexibility exceeds by one or two per cent."""
    table = drawn.table(wheelset_receptances, "wheelset_receptances")
    assert table["frequency (Hz)"][0] == 0
    k, box, contact = 2e6, 1.0275, 0.75
    heave, roll = 1 / (2 * k), contact**2 / (2 * k * box**2)
    for name, rigid in (("direct wheel 1", heave + roll), ("direct wheel 2", heave + roll), ("cross", heave - roll)):
        assert table[f"{name} magnitude (m/N)"][0] == pytest.approx(1.012 * rigid, rel=0.01)
        assert table[f"{name} phase (deg)"][0] == 0
    assert table["frequency (Hz)"][-1] == 2500
    phase = table["direct wheel 1 phase (deg)"]
    assert phase.min() > -180.01  # a passive body never leads its load, nor lags by more than half a turn
    assert phase.max() < 0.01


@pytest.mark.slow
def test_stress_peaks_at_the_bending_modes(drawn) -> None:
    table = drawn.table(wheelset_receptances, "axle_stress_response")
    frequency, stress = table["frequency (Hz)"], table["sigma_yy A1 load on wheel 1 magnitude (Pa/N)"]
    for low, high, known in ((100, 300, 206), (1700, 2400, 1920)):
        among = (frequency > low) & (frequency < high)
        assert frequency[among][stress[among].argmax()] == pytest.approx(known, rel=0.01)
    both = stress[0] + table["sigma_yy A1 load on wheel 2 magnitude (Pa/N)"][0]
    assert both * SCENARIO.wheel_load == pytest.approx(65.8e6, rel=0.03)


@pytest.mark.slow
def test_no_peak_falls_between_frequencies(drawn, reduced) -> None:
    stress = drawn.table(wheelset_receptances, "axle_stress_response")["sigma_yy A1 load on wheel 2 magnitude (Pa/N)"]
    fine = reduced.stress_receptance(np.linspace(406.5, 407.5, 5001))[:, 0, 1, 1]
    assert stress.max() == pytest.approx(np.abs(fine).max(), rel=1e-3)


def test_labels_of_neighbouring_peaks_stand_apart() -> None:
    frequencies = np.geomspace(1.0, 2500.0, 5001)
    peaks = [205.0, 407.0, 1574.0, 1912.0]
    heights = [1.4e4, 3e4, 1.5e4, 6e3]
    values = sum(h / (1 + (500 * np.log(frequencies / f)) ** 2) for h, f in zip(heights, peaks, strict=True))
    with new_figure(3.6, "", "") as figure:
        axes = figure.subplots()
        axes.loglog(frequencies, values)
        axes.set(xlim=(1.0, 2500.0), ylim=(1e-2, 1e5))
        assert drawing.label_peaks(axes, frequencies, values, 4) == pytest.approx(peaks, rel=1e-3)
        figure.canvas.draw()
        boxes = [text.get_window_extent() for text in axes.texts]
    for box, other in pairwise(boxes):
        assert not box.overlaps(other)


@pytest.mark.slow
def test_green_functions_of_the_wheelset(drawn) -> None:
    table = drawn.table(wheelset_receptances, "wheelset_green_functions")
    assert table["time (s)"][-1] == pytest.approx(1.0, abs=4e-5)
    printed, modal = (table[f"{name} direct wheel 1 (m/(N s))"] for name in ("band-limited", "modal"))
    assert abs(modal[0]) < 1e-3 * modal.max()
    assert printed[0] > 0.02 * modal.max()  # what the band limit makes of the rise at t = 0
    assert np.abs(printed - modal).mean() < 0.02 * modal.max()
    # The area under the impulse response is the static receptance.
    static = drawn.table(wheelset_receptances, "wheelset_receptances")
    dt = table["time (s)"][1]
    for name, first in (("direct wheel 1", "direct wheel 1"), ("cross", "cross")):
        area = table[f"modal {name} (m/(N s))"].sum() * dt
        assert area == pytest.approx(static[f"{first} magnitude (m/N)"][0], rel=5e-3)


@pytest.mark.slow
def test_modes_of_figure_12(drawn) -> None:
    table = drawn.table(wheelset_modes, "wheelset_modes")
    titles = [title for title in table if title.startswith("u_r")]
    for title, known, fewest in zip(titles, (206, 1920), (1, 3), strict=True):
        frequency = float(title.split()[2])
        assert frequency == pytest.approx(known, rel=0.01)
        assert "n = 1" in title
        shape = np.stack([table[title.replace("u_r", part)] for part in ("u_r", "u_y", "u_theta")], axis=1)
        assert np.linalg.norm(shape, axis=1).max() == pytest.approx(1)
        axis = (table["r (m)"] == 0) & (np.abs(table["y (m)"]) < 0.7)
        bent = shape[axis, 0][np.argsort(table["y (m)"][axis])]
        assert (np.diff(np.sign(bent)) != 0).sum() >= fewest  # nodes between the wheels


@pytest.mark.slow
def test_the_mode_is_the_one_that_the_stress_answers_to(reduced) -> None:
    _, found = mode_shapes(load_wheelset("x40"), 2400)
    near = wheelset_modes.decisive_mode(found, reduced, "A1", 1800)
    among = np.linspace(1500, 2160, 20001)
    response = np.abs(reduced.stress_receptance(among)[:, 0, 1, 0])
    assert near.frequency == pytest.approx(among[response.argmax()], abs=0.1)
    with pytest.raises(InputError, match="no mode within"):
        wheelset_modes.decisive_mode(found, reduced, "A1", 1e5)


@pytest.mark.slow
def test_track_statics_and_resonances(drawn) -> None:
    table = drawn.table(track_receptances, "track_receptances")
    for place, static in (("above a sleeper", 1.112e-8), ("mid-bay", 1.144e-8)):
        assert table[f"direct {place} magnitude (m/N)"][0] == pytest.approx(static, rel=1e-3)
    features = drawn.table(track_receptances, "track_receptances_features")
    rows = zip(features["feature"], features["place"], features["frequency (Hz)"], strict=True)
    assert {(name, place): frequency for name, place, frequency in rows} == {
        ("track resonance", "above a sleeper"): pytest.approx(75, rel=0.01),
        ("track resonance", "mid-bay"): pytest.approx(75, rel=0.01),
        ("anti-resonance", "above a sleeper"): pytest.approx(173, rel=0.01),
        ("anti-resonance", "mid-bay"): pytest.approx(163, rel=0.01),
        ("rail on pads", "above a sleeper"): pytest.approx(292, rel=0.01),
        ("rail on pads", "mid-bay"): pytest.approx(292, rel=0.01),
        ("pinned–pinned", "mid-bay"): pytest.approx(1073, rel=0.01),
    }


def test_pinned_pinned_frequency_by_its_closed_form() -> None:
    """Euler-Bernoulli's frequency, less what shear and rotation take from it to first order."""
    track = load_track("ballasted_60e1")
    long = replace(track, spacing=3.0)
    k = np.pi / long.spacing
    slender = k**2 * np.sqrt(track.rail.EI / track.rail.rhoA) / (2 * np.pi)
    softer = 1 - k**2 / 2 * (track.rail.EI / track.rail.kGA + track.rail.rhoI / track.rail.rhoA)
    assert track_receptances.pinned_pinned(long) == pytest.approx(slender * softer, rel=1e-3)
    assert track_receptances.pinned_pinned(track) == pytest.approx(1073, rel=0.01)


@pytest.mark.slow
def test_finite_elements_beside_the_waves(drawn) -> None:
    table = drawn.table(track_receptances, "track_receptances_by_finite_elements")
    low = table["frequency (Hz)"] < 300
    for place in ("above a sleeper", "mid-bay"):
        elements, waves = (table[f"{by}, direct {place} magnitude (m/N)"] for by in ("finite elements", "Bloch waves"))
        np.testing.assert_allclose(elements[low], waves[low], rtol=1e-3)


@pytest.mark.slow
def test_moving_green_functions_of_both_dynamics(drawn) -> None:
    table = drawn.table(moving_green_functions, "moving_green_functions")
    dt = table["time (s)"][1]
    for start, static in (("above a sleeper", 1.112e-8), ("mid-bay", 1.144e-8)):
        paper, causal = (table[f"{name} loaded rail {start} (m/N)"] for name in ("paper", "causal"))
        # A steady load is the sum of its impulses: the mean static deflection of the bay, but for what comes later.
        assert causal.sum() == pytest.approx(static, rel=0.04)
        # The paper's sum lacks what the band limit puts before t = 0: about 1e-10 m/N.
        assert causal.sum() - paper.sum() == pytest.approx(7e-11, abs=4e-11)
        later = table["time (s)"] > 2e-3
        assert np.abs(paper - causal)[later].max() < 0.02 * causal.max()
        # The band limit halves the step that the rail's shear wave makes at t = 0; Eq. (3) halves it again.
        step = moving_green_functions.first_displacement(load_track("ballasted_60e1")) * dt
        assert paper[0] / step == pytest.approx(0.25, abs=0.06)
        other, ring = (table[f"{name} opposite rail {start} (m/N)"] for name in ("paper", "causal"))
        assert np.abs(other - ring).max() < 0.1 * np.abs(other).max()


@pytest.mark.parametrize("start", [0, 211])
def test_the_impulse_is_that_of_the_coupled_step(start, reduced) -> None:
    speed, dx, steps = SCENARIO.speed, SCENARIO.step_length, 700
    ring = track_ring(load_track("ballasted_60e1"), dx)
    rails = moving_green_functions.ring_impulse(ring, speed, start, steps)
    running = moving_track(load_track("ballasted_60e1"), dx)
    dynamics = causal_model(reduced, running, ("A1",), "residual").start(0.0, start, dx, speed)
    xi, stepped = np.zeros((2, 2)), np.zeros((steps, 2))
    for n in range(steps):
        displacements(dynamics, start + n, xi)
        stepped[n] = xi[1]
        advance(dynamics, start + n, np.array([float(n == 0), 0.0]))
    # the coupled step has the ring in its reduced form
    np.testing.assert_allclose(rails.loaded[1:], stepped[1:, 0], atol=5e-4 * rails.loaded.max())
    np.testing.assert_allclose(rails.opposite[1:], stepped[1:, 1], atol=5e-4 * rails.loaded.max())
    assert 0.3 < rails.loaded[0] / rails.loaded[1] < 1.5


@pytest.mark.slow
def test_a_scenario_of_ones_own(tmp_path) -> None:
    """Another band and another node stand in figures and tables."""
    mine: Scenario = replace(SCENARIO, max_frequency=1000.0, output=Output(("C1",)))
    wheelset_receptances.draw(tmp_path, mine)
    table = read(tmp_path / "axle_stress_response.csv")
    assert "sigma_yy C1 load on wheel 1 magnitude (Pa/N)" in table
    assert table["frequency (Hz)"][-1] == 1000
    track_receptances.draw(tmp_path, mine)
    assert "pinned–pinned" not in read(tmp_path / "track_receptances_features.csv")["feature"]


def test_refusals(tmp_path) -> None:
    with pytest.raises(InputError, match="stress_nodes is empty"):
        wheelset_modes.draw(tmp_path, replace(SCENARIO, output=Output(())))
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        drawing.table(tmp_path / "file", "any", {"x (m)": np.zeros(1)})
    with (
        new_figure(1.0, "any", "any") as figure,
        pytest.raises(InputError, match="cannot be written"),
    ):
        drawing.save(tmp_path / "file", "any", figure)


def test_phase_of_lightly_damped_responses_does_not_flicker() -> None:
    near = np.array([-1 + 1e-9j, -1 - 1e-9j, 1 + 1e-9j, 1 - 1e-9j, 1j, -1j])
    np.testing.assert_allclose(drawing.phase_degrees(near), [-180, -180, 0, 0, -270, -90], atol=1e-6)
    shown = drawing.unbroken(np.array([-200.0, -260.0, 80.0, 10.0]))
    np.testing.assert_array_equal(np.isnan(shown), [False, False, True, False])
