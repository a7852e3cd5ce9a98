"""Section 8: what an upper bound on the contact pressure does to forces and stresses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from wheelset_track_sim.contact import HertzContact
from wheelset_track_sim.contact.active_set_kernels import solve_active_set
from wheelset_track_sim.contact.hardness import STEEL, share_from
from wheelset_track_sim.contact.influence import contact_modulus, influence_table
from wheelset_track_sim.contact.yielding_kernels import solve_yielding
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

from .page import number, paragraphs, percent, table
from .runs import BEFORE, Passage, must, passage, shared_models
from .store import recall

CASES = (
    ("flat_fresh", "fresh flat, 60 mm"),
    ("flat_rounded", "the same, rounded to 120 mm"),
    ("damage_wheel_1", "breakout, 2 mm"),
)
HARDNESSES: tuple[float | None, ...] = (None, 3.5e9, STEEL, 2.0e9)
LENGTHS = (0.002, 0.001, 0.0005)
NEAR = 0.12
"""Distance from the defect within which pressures are solved, m."""

RADIUS, MOST, FORCE = 0.36, 1.2e9, 150e3
"""Of the sphere: radius, m, hardness, Pa, and load, N, with which ``tests/validation`` compares tamaas."""


def _changes(hardness: float | None, length: float = 0.001) -> list[str]:
    return [f"step_length={length}", *([] if hardness is None else [f"contact.hardness={hardness}"])]


def _pressures(name: str, changes: Sequence[str]) -> dict[str, float]:
    """Largest pressure of wheel 1 in GPa, anywhere near the defect and at its largest force, and the share there."""
    scenario = load_scenario(name, changes)
    dx = scenario.step_length
    simulator = Simulator(scenario, models=shared_models(scenario, True, None))
    simulator.advance(round((scenario.reference_position - BEFORE) / dx))
    forces = simulator.advance(round(2 * BEFORE / dx)).forces[:, 0]
    middle, reach = round(BEFORE / dx), round(NEAR / dx)
    largest = max(
        float(simulator.contact_patch(0, row).pressure.max()) for row in range(middle - reach, middle + reach + 1)
    )
    patch = simulator.contact_patch(0, int(forces.argmax()))
    return {
        "largest": largest / 1e9,
        "at_peak": float(patch.pressure.max()) / 1e9,
        "share": share_from(patch.pressure, patch.hardness),
    }


def _sphere() -> list[list[float]]:
    """Elements, mm, and of a sphere under FORCE: approach, um, and the areas that touch and that yield, mm^2."""
    rows = []
    for width in (1e-3, 5e-4, 3.5e-4):
        cells = round(0.028 / width)
        x = (np.arange(cells) - cells / 2 + 0.5) * width
        gap, influence = (
            (x[:, None] ** 2 + x**2) / (2 * RADIUS),
            influence_table(cells, cells, width, width, 210e9, 0.3),
        )
        pressure = np.empty(gap.shape)

        def force(
            approach: float, gap: Any = gap, influence: Any = influence, width: float = width, pressure: Any = pressure
        ) -> float:
            of, contact = (gap, False, influence, width**2, approach, 0.0), np.zeros(gap.shape, np.bool_)
            solve_active_set(*of, contact, pressure)
            solve_yielding(*of, MOST, contact, pressure)
            return float(pressure.sum() * width**2)

        elastic = HertzContact(RADIUS, RADIUS, contact_modulus(210e9, 0.3)).approach(FORCE)
        approach = brentq(lambda each: force(each) - FORCE, elastic, 1.5 * elastic, xtol=1e-12)
        areas = [float((pressure > 0).sum()), float((pressure == MOST).sum())]
        rows.append([1e3 * width, 1e6 * approach, *(1e6 * width**2 * each for each in areas)])
    return rows


def _found(name: str, hardness: float | None, length: float = 0.001) -> tuple[Passage, dict[str, float]]:
    """A passage and its pressures."""
    changes = _changes(hardness, length)
    found = recall("pressures", [name, changes], lambda: _pressures(name, changes))
    return must(passage(name, changes)), found


def flat() -> tuple[float, float]:
    """Of the fresh flat: share of the elastic force above the hardness of steel, and what that hardness takes off."""
    elastic, bounded = (_found("flat_fresh", each) for each in (None, STEEL))
    return elastic[1]["share"], 1 - bounded[0].largest[0] / elastic[0].largest[0]


def _row(title: str, name: str, hardness: float | None) -> list[Any]:
    run, found = _found(name, hardness)
    bound = "none" if hardness is None else f"{hardness / 1e9:g} GPa"
    of_force = of_stress = None
    if hardness is not None:
        elastic, _ = _found(name, None)
        of_force = percent(run.largest[0], elastic.largest[0])
        of_stress = percent(run.stress[0], elastic.stress[0], 2)
    return [
        *(title, bound, found["largest"], found["at_peak"], f"{100 * found['share']:.0f} %"),
        *(run.largest[0], of_force, run.loss[0], *run.stress, of_stress),
    ]


def _step(length: float) -> list[Any]:
    row: list[Any] = [f"{1e3 * length:g} mm"]
    for hardness in (None, STEEL):
        run, found = _found("flat_fresh", hardness, length)
        row += [found["largest"], run.largest[0], run.stress[0]]
    return row


def section() -> str:
    """Text of the section."""
    rows = [_row(title, name, hardness) for name, title in CASES for hardness in HARDNESSES]
    fresh = {row[1]: row for row in rows if row[0] == CASES[0][1]}
    steel = fresh[f"{STEEL / 1e9:g} GPa"]
    return paragraphs(
        "## 8. What steel can bear",
        "The contact is linear elastic, and nothing in it bounds the pressure. At the sharp edge of a fresh flat the "
        "pressure grows without limit as elements shrink. Steel yields. `contact: {hardness: H}` bounds the pressure, "
        "0 ≤ p ≤ H ([scenarios.md](reference/scenarios.md)). Causal, 20 t, 100 km/h. *Share* is the share of the "
        f"largest force on elements at the bound, or above {STEEL / 1e9:g} GPa where there is none:",
        table(
            (
                "defect",
                "bound",
                "largest pressure, GPa",
                "at the largest force, GPa",
                "share",
                "max 1, kN",
                "to none",
                "lost 1, ms",
                "A1, MPa",
                "B1, MPa",
                "C1, MPa",
                "A1 to none",
            ),
            rows,
            (0, 0, 2, 2, 0, 1, 0, 2, 1, 1, 1, 0),
        ),
        f"* The pressure under a fresh flat, {number(fresh['none'][2])} GPa, is not real. The force hardly changes. "
        f"The bound of {STEEL / 1e9:g} GPa takes {steel[6].lstrip('-')} off it, and {steel[11].lstrip('-')} off A1.\n"
        "* A rounded flat and a breakout yield little or not at all. The elastic contact is good enough for both.\n"
        "* Plastic deformation is not kept. Running rounds a fresh flat; give its `worn_length` for that.",
        "The fresh flat with other steps, which are also the lengths of its elements. On the left without a bound, on "
        f"the right with {STEEL / 1e9:g} GPa:",
        table(
            ("step", "pressure, GPa", "max 1, kN", "A1, MPa", "pressure, GPa", "max 1, kN", "A1, MPa"),
            map(_step, LENGTHS),
            (0, 2, 1, 1, 2, 1, 1),
        ),
        f"Against another code: a sphere of {1e3 * RADIUS:g} mm with a hardness of {MOST / 1e9:g} GPa. Pressures agree "
        "with the saturated solver of tamaas (L. Frérot et al., J. Open Source Software 5 (2020) 2121) on the same "
        "elements within 10⁻⁷ of the hardness, at 100, 150 and 250 kN (`tests/validation/test_contact_saturated.py`). "
        f"With smaller elements, at {FORCE / 1e3:g} kN:",
        table(
            ("elements, mm", "approach, µm", "in contact, mm²", "yielded, mm²"),
            recall("saturated-sphere", [RADIUS, MOST, FORCE], _sphere),
            (2, 2, 1, 1),
        ),
    )
