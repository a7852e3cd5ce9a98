"""Section 9: the linear answer to waves of a rail, amplitude and phase, against the receptances."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from wheelset_track_sim.contact import approach_for_force, solve_patch
from wheelset_track_sim.irregularities import Corrugation
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import Models, load_models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track import bloch

from .page import paragraphs, table
from .store import recall

AMPLITUDE = 1e-6
"""Of the waves, m: a hundredth of what the static load presses in, so that the answer is linear."""
WAVES = (
    *((27.7777778, each) for each in (1400, 900, 600, 360, 250, 160, 110)),
    *((100.0, each) for each in (400, 250, 160, 120, 100, 90, 80, 60, 50)),
)
"""Speed, m/s, and wavelength, mm."""
PLACES = 24
"""Of a bay over which receptances are averaged."""
LONG, SKIPPED = 12000, 4000
"""Steps over which an answer is taken at least, and before it."""


def _measured(speed: float, wave: int) -> tuple[complex, complex, Models]:
    """Force of wheel 1, N, for a height of rail 1 as the static contact feels it, m: complex amplitudes."""
    scenario = dataclasses.replace(load_scenario("undamaged"), speed=speed)
    models = load_models(scenario, tables="smooth")
    together = math.lcm(wave, round(scenario.track.spacing * 1e3))
    steps = -(-LONG // together) * together
    shape = Corrugation("rail_1", wavelength=wave * 1e-3, amplitude=AMPLITUDE)
    found = []
    for shapes in ((), (shape,)):
        run = Simulator(dataclasses.replace(scenario, irregularities=shapes, line_length=together / 1e3), models=models)
        run.advance(SKIPPED)
        parts = []
        while run.next_step < SKIPPED + steps:
            parts.append(run.advance(min(2000, SKIPPED + steps - run.next_step)).forces[:, 0])
        found.append(np.concatenate(parts))
    turns = np.exp(-2j * np.pi * (SKIPPED + np.arange(steps)) / wave)
    force = 2 / steps * (turns @ (found[1] - found[0]))

    load, law = scenario.wheel_load, models.contact_law((shape,), line_length=together / 1e3)
    at = np.arange(wave)
    approach = np.array([approach_for_force(law, 0, 0, int(n), load) for n in at])
    height = -2 / wave * (np.exp(-2j * np.pi * at / wave) @ approach)
    return force, height, models


def _expected(models: Models, frequency: float, load: float) -> complex:
    """Force, N, by a unit of height under wheel 1: (1/k_H + H_w + H_r) F = h."""
    track, law = models.track, models.contact_law(())
    places = np.arange(PLACES) * track.spacing / PLACES
    direct, cross = np.mean(
        [[part[0, 0] for part in bloch.receptance(track, [frequency], x, [x])] for x in places], axis=0
    )
    k = solve_patch(law, 0, 0, 0, approach_for_force(law, 0, 0, 0, load)).stiffness
    compliance = models.reduced.receptance(np.array([frequency]))[0] + np.array([[direct, cross], [cross, direct]])
    return complex(np.linalg.solve(compliance + np.eye(2) / k, [1.0, 0.0])[0])


def _row(speed: float, wave: int) -> list[float]:
    force, height, models = _measured(speed, wave)
    frequency = speed / (wave * 1e-3)
    ours, expected = force / height, _expected(models, frequency, load_scenario("undamaged").wheel_load)
    ratio = ours / expected
    return [
        *(frequency, speed, wave, abs(height) / AMPLITUDE, abs(ours) / 1e9, abs(expected) / 1e9),
        *(100 * (abs(ratio) - 1), float(np.degrees(np.angle(ours))), float(np.degrees(np.angle(ratio)))),
    ]


def rows() -> list[list[float]]:
    """Of each wave what the table shows."""
    return [recall("coupling", each, lambda each=each: _row(*each)) for each in WAVES]


def worst(low: float, high: float) -> float:
    """Largest difference of amplitudes to the expected ones from ``low`` to ``high`` Hz, %."""
    return max(abs(row[6]) for row in rows() if low <= row[0] <= high)


def section() -> str:
    """Text of the section."""
    return paragraphs(
        "## 9. Linear coupling",
        f"Waves of {AMPLITUDE * 1e6:g} µm on rail 1 from 20 to 2000 Hz, causal dynamics, against the linear answer of "
        "the receptances: (1/k + H_w + H_r) F = h, with the wheelset's receptances, those of the standing track from "
        "Bloch waves averaged over a bay, and the stiffness of the contact. *Felt* is the part of the wave that a "
        "contact under the static load feels, for a patch is not a point. Force of wheel 1 for a height of that size:",
        table(
            (
                *("frequency, Hz", "speed, m/s", "wave, mm", "felt", "force, kN/µm", "expected", "difference, %"),
                *("phase, °", "difference, °"),
            ),
            rows(),
            (1, 1, 0, 3, 3, 3, 1, 1, 1),
        ),
        "The rail answers a moving load, and averages are taken of a standing one: near the pinned-pinned frequency of "
        "1073 Hz the answer depends on the place in the bay, and the two differ most.",
    )
