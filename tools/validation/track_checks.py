"""What is computed for section 6: two methods, closed forms, and tracks with other ballast and rings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy.signal import argrelmax, argrelmin

from wheelset_track_sim.dynamics.causal import causal_model
from wheelset_track_sim.scenario import Scenario
from wheelset_track_sim.simulation.models import Models
from wheelset_track_sim.track import bay, bloch
from wheelset_track_sim.track import finite_elements as track_fe
from wheelset_track_sim.track.balance import ORDER, MovingTrack, balanced
from wheelset_track_sim.track.bay import HalfSleeper, half_sleeper
from wheelset_track_sim.track.ring import track_ring
from wheelset_track_sim.track.track import Half, Track, load_track
from wheelset_track_sim.wheelset.reduction import reduced_wheelset

from .store import recall

Real = NDArray[np.float64]

TRACK = load_track("ballasted_60e1")
APART = np.array([20.0, 75.0, 163.0, 292.0, 500.0, 800.0, 1500.0, 2000.0, 2500.0])
"""Hz, away from the pinned-pinned resonance, to which the ends of a finite track matter."""
BANDS = ((0, 300), (300, 1000), (1000, 1150), (1150, 2000), (2000, 2500))
RINGS = ((40, 5000.0), (80, 5000.0), (140, 5000.0), (200, 5000.0), (140, 7000.0))
"""Bays, and Hz to which modes are kept."""


def pinned_pinned(track: Track) -> float:
    """First natural frequency, Hz, of the rail between two sleepers as a simply supported Timoshenko beam.

    ``(kGA k^2 - rhoA w^2) (EI k^2 + kGA - rhoI w^2) = (kGA k)^2`` with ``k = pi / L``.
    """
    rail, k = track.rail, np.pi / track.spacing
    a = rail.rhoA * rail.rhoI
    b = -(rail.rhoA * (rail.EI * k**2 + rail.kGA) + rail.rhoI * rail.kGA * k**2)
    c = rail.kGA * k**2 * (rail.EI * k**2 + rail.kGA) - (rail.kGA * k) ** 2
    return float(np.sqrt(np.roots([a, b, c]).min()) / (2 * np.pi))


def _resonances() -> Any:
    f = np.arange(20.0, 1200.0, 0.1)
    above, middle = (np.abs(bloch.receptance(TRACK, f, x, x)[0][0]) for x in (0.0, 0.3))
    loose = replace(TRACK, pad=replace(TRACK.pad, length=1e-3))  # next to no rotational spring
    near = pinned_pinned(TRACK) + np.arange(-5.0, 5.0, 0.005)
    peak = near[np.abs(bloch.receptance(loose, near, 0.3, 0.3)[0][0]).argmax()]
    rigid = [float(bloch.receptance(TRACK, 0.0, x, x)[rail][0, 0].real) for x in (0.0, 0.3) for rail in (0, 1)]
    return {
        "above": [float(v) for v in f[argrelmax(above)][:2]],
        "above_low": float(f[argrelmin(above)][0]),
        "middle": [float(v) for v in f[argrelmax(middle)][:3]],
        "middle_low": float(f[argrelmin(middle)][0]),
        "pinned": float(peak),
        "static": rigid,
    }


def _methods() -> Any:
    places, errors = [0.3, 0.6, 3.0], []
    waves = bloch.receptance(TRACK, APART, 0.3, places)
    level = np.abs(waves[0]).max(axis=0)
    for elements in (8, 16, 32):
        finer = replace(TRACK, rail=replace(TRACK.rail, elements_per_bay=elements))
        found = track_fe.receptance(finer, APART, 0.3, places)
        gap = np.max([np.abs(a - b).max(axis=0) / level for a, b in zip(found, waves, strict=True)], axis=0)
        errors.append([elements, float(gap[APART < 300].max()), float(gap[APART == 1500].max()), float(gap.max())])
    x = np.array([0.0, 0.037, 0.3, 0.55, 0.61, -1.4])
    static = []
    for load in (0.0, 0.3, 0.211):
        pairs = zip(track_fe.receptance(TRACK, 0.0, load, x), bloch.receptance(TRACK, 0.0, load, x), strict=True)
        static.append(max(float(np.abs(a / b - 1).max()) for a, b in pairs))
    return {"elements": errors, "static": max(static)}


def _ring() -> Any:
    rows = []
    for bays, limit in RINGS:
        ring = track_ring(TRACK, 1e-3, bays=bays, max_frequency=limit)
        errors = []
        for low, high in BANDS:
            f, gaps = np.arange(low, high, 4.0), []
            for place in (0, 137, 300):
                exact = bloch.receptance(TRACK, f, place * 1e-3, place * 1e-3)
                gaps += [
                    float(np.max(np.abs(mine - infinite[0]) / np.abs(exact[0][0])))
                    for mine, infinite in zip(ring.receptance(f, place), exact, strict=True)
                ]
            errors.append(max(gaps))
        rows.append([bays, limit, *errors])
    return rows


def with_ring(bays: int, limit: float, scenario: Scenario, models: Models) -> Models:
    """Models on another ring, reduced as the default one."""
    ring = track_ring(models.track, scenario.step_length, bays=bays, max_frequency=limit)
    reduced = reduced_wheelset(models.wheelset)
    running = MovingTrack(balanced(ring.symmetric, ORDER), balanced(ring.antisymmetric, ORDER))
    dynamics = causal_model(reduced, running, scenario.output.stress_nodes, scenario.at_lag_zero)
    return replace(models, dynamics=dynamics)


def even_springs(nodes: Real) -> Real:
    """One spring for each node, all alike."""
    return np.ones_like(nodes)


def tamped(nodes: Real) -> Real:
    """Ballast by tributary length, but none within 0.4 m of the centre."""
    share = np.ones_like(nodes)
    share[-1] /= 2
    share[nodes < 0.4] = 0.0
    return share


@contextmanager
def ballast(law: Callable[[Real], Real]) -> Iterator[None]:
    """Half sleepers within it stand on ballast that is shared among their nodes as ``law`` of their places says."""

    def shared(track: Track, half: Half) -> HalfSleeper:
        bare = replace(track, ballast=replace(track.ballast, stiffness=1e6, damping=1.0))
        plain, none = half_sleeper(track, half), half_sleeper(bare, half)
        # What two ballasts differ by is the ballast alone: its share at each deflection.
        own = (plain.stiffness - none.stiffness).diagonal() / (track.ballast.stiffness - 1e6)
        there = own > 0
        nodes = np.linspace(0.0, track.sleeper.length / 2, track.sleeper.elements // 2 + 1)
        share = law(nodes)
        share[0] /= 2  # the middle node is half of this half's
        share /= 2 * share.sum()
        share = share[-int(there.sum()) :]  # an antisymmetric half has no deflection in the middle
        stiffness, damping = plain.stiffness.copy(), plain.damping.copy()
        places = np.flatnonzero(there)
        stiffness[places, places] += (share - own[places]) * track.ballast.stiffness
        damping[places, places] += (share - own[places]) * track.ballast.damping
        return replace(plain, stiffness=stiffness, damping=damping)

    with (
        TemporaryDirectory() as folder,
        patch.dict("os.environ", WHEELSET_TRACK_SIM_CACHE=folder),
        patch.object(bay, "half_sleeper", shared),
    ):
        yield


def resonances() -> Any:
    """Frequencies, Hz, and static receptances, m/N, by Bloch waves."""
    return recall("resonances", [TRACK], _resonances)


def methods() -> Any:
    """Finite elements against Bloch waves."""
    return recall("track-methods", [TRACK], _methods)


def rings() -> Any:
    """Rings against Bloch waves, by bands."""
    return recall("ring", RINGS, _ring)
