"""The bound on the ripple at the sleepers, and what the printed ripple makes of the printed impact (section 3)."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

from wheelset_track_sim.dynamics.interface_kernels import advance, displacements
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.track import bloch

from .load_cases import printed
from .page import number, paragraphs, table
from .runs import Passage, must, passage, shared_models
from .store import recall

SMOOTH, DAMAGED = "undamaged", "damage_wheel_1"
SPEEDS = (80, 90, 100, 120, 180)
"""km/h"""
PLACES = 24
"""Of a bay over which receptances are averaged."""
SETTLED = 2.0
"""Time after which the rail has come to its steady deflection, s."""
PHASES = 12
RAILFE = 3.8
"""Half of the range of the force that railFE, a public code of one rail with a linear contact, gives with the printed
track at 100 km/h, kN."""


def _deflection(speed: float) -> float:
    """Fundamental over a bay of the rails' deflection under both static loads in motion, amplitude in m."""
    scenario = load_scenario(SMOOTH, [f"speed={speed}"])
    dx, model = scenario.step_length, shared_models(scenario, True, None).dynamics
    dynamics, xi = model.start(0.0, 0, dx, speed), np.empty((2, 2))
    load, bay = np.full(2, scenario.wheel_load), len(dynamics.rail_compliance)
    steps = round(SETTLED * speed / dx / bay) * bay
    deflections = np.empty(bay)
    for step in range(steps):
        displacements(dynamics, step, xi)
        if step >= steps - bay:
            deflections[step % bay] = xi[1, 0] + dynamics.rail_compliance[step % bay] * load[0]
        advance(dynamics, step, load)
    return float(2 * np.abs(np.fft.rfft(deflections)[1]) / bay)


def _yielding(frequency: float) -> float:
    """-Im R_t, m/N: of a rail under equal forces on both, averaged over the bay."""
    track = load_scenario(SMOOTH).track
    places = np.arange(PLACES) * track.spacing / PLACES
    both = [sum(part[0, 0] for part in bloch.receptance(track, [frequency], x, [x])) for x in places]
    return float(-np.mean(both).imag)


def bounds() -> list[dict[str, float]]:
    """Of each speed: passing frequency, Hz, e1, um, -Im R_t, 1e-9 m/N, bound and our ripple, kN."""
    spacing, found = load_scenario(SMOOTH).track.spacing, []
    for speed in SPEEDS:
        frequency = speed / 3.6 / spacing
        e1, loss = recall("bound", [speed], lambda speed=speed, f=frequency: [_deflection(speed / 3.6), _yielding(f)])
        run = must(passage(SMOOTH, [f"speed={speed / 3.6}"]))
        x, force = np.array(run.x)[:-1], np.array(run.force[0])[:-1]  # whole bays
        ours = float(2 * np.abs(np.mean(force * np.exp(2j * np.pi * x / spacing))))
        found.append(
            {"speed": speed, "f": frequency, "e1": 1e6 * e1, "loss": 1e9 * loss, "bound": 1e-3 * e1 / loss, "ours": ours}
        )
    return found


def _with_ripple(case: str, amplitude: float, phase: float) -> Passage:
    waves = ", ".join(
        f"{{type: corrugation, on: {rail}, wavelength: 0.6, amplitude: {amplitude!r}, phase: {phase!r}}}"
        for rail in ("rail_1", "rail_2")
    )
    damage = "".join(f", {{type: breakout, on: {d.on}, a: {d.a}, b: {d.b}, h: {d.h}}}" for d in _defects(case))
    return must(passage(case, [f"irregularities=[{waves}{damage}]", "settle_on=surfaces"], tables=False))


@lru_cache(maxsize=4)
def _defects(case: str) -> tuple[Any, ...]:
    return load_scenario(case).irregularities


def raised() -> list[dict[str, Any]]:
    """Case 2 on a rail whose height makes the printed ripple: amplitude by the printed 131 kN, at each phase."""
    wanted = printed(0, "largest", 0) or 0.0

    def compute() -> Any:
        found = []
        for phase in np.arange(PHASES) * 2 * np.pi / PHASES:
            phase = round(float(phase), 9)
            amplitude = brentq(
                lambda a, phase=phase: _with_ripple(SMOOTH, a, phase).largest[0] - wanted, 2e-5, 4e-4, rtol=1e-4
            )
            hit = _with_ripple(DAMAGED, round(amplitude, 9), phase)
            found.append(
                {"phase": phase, "amplitude": amplitude, "largest": hit.largest, "low": hit.smallest, "stress": hit.stress}
            )
        return found

    result: list[dict[str, Any]] = recall("raised", [wanted, PHASES], compute)
    return result
