"""Fig. 8: moving Green's functions of both rails, by the paper's inverse transform and by the causal ring of bays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..dynamics.green_functions import integrated
from ..dynamics.hold import hold_coefficients
from ..dynamics.moving_green_functions import moving_green_functions
from ..report.figures import COLOURS, finish, new_figure
from ..runtime.arrays import Real
from ..runtime.progress import Progress
from ..scenario import Scenario
from ..track.ring import MAX_FREQUENCY, HalfRing, TrackRing, track_ring
from ..track.track import Track
from . import drawing
from .drawing import Look

SHOWN = 0.05
"""s, as in Fig. 8."""
CLOSE = {"loaded rail": 0.002, "opposite rail": 0.015}
"""First part of them, s: where the two dynamics differ, and where the other rail begins to move."""
STARTS = ("above a sleeper", "mid-bay")
DASHES = ("-", (0, (4, 1.5)))
DARK = ("#5b2600", "#001f33")
"""The causal curves: darker shades of those of the paper."""


class Rails(NamedTuple):
    """Time-integrated moving Green's functions (samples,) of Eq. (3) in m/N."""

    loaded: Real
    opposite: Real


def draw(out: Path, scenario: Scenario, progress: Progress | None = None) -> list[Path]:
    """Write ``moving_green_functions`` into ``out``: at the scenario's speed, for loads above a sleeper and mid-bay.

    Raises InputError for a track or a step length that cannot be used, and for a folder that cannot be written.
    """
    track, dx, dt = scenario.track, scenario.step_length, scenario.step_period
    limit = drawing.band(scenario)
    ring = track_ring(
        track, dx, max_frequency=min(scenario.max_frequency or MAX_FREQUENCY, MAX_FREQUENCY), progress=progress
    )
    time: Real = np.arange(round(SHOWN / dt) + 1, dtype=np.float64) * dt
    table = moving_green_functions(
        track, scenario.speed, dx, max_frequency=limit, starts=len(STARTS), progress=progress
    )
    paper, causal = {}, {}
    for index, start in enumerate(STARTS):
        whole = (integrated(rail[index], dt)[: len(time)] for rail in (table.direct, table.cross))
        paper[start] = Rails(*whole)
        causal[start] = ring_impulse(ring, scenario.speed, index * round(track.spacing / dx) // len(STARTS), len(time))
    columns = {"time (s)": time}
    for name, functions in (("paper", paper), ("causal", causal)):
        for start, rails in functions.items():
            columns[f"{name} loaded rail {start} (m/N)"] = rails.loaded
            columns[f"{name} opposite rail {start} (m/N)"] = rails.opposite
    paths = _figure(out, track, scenario, time, paper, causal)
    return [*paths, drawing.table(out, "moving_green_functions", columns)]


def _figure(
    out: Path, track: Track, scenario: Scenario, time: Real, paper: Mapping[str, Rails], causal: Mapping[str, Rails]
) -> list[Path]:
    speed, dt = 3.6 * scenario.speed, scenario.step_period
    title = f"Track {track.name}: moving Green's functions at {speed:g} km/h"
    missing = [1e12 * (causal[start].loaded - paper[start].loaded).sum() for start in STARTS]
    made = (
        f"Paper dynamics: receptances up to {drawing.band(scenario):g} Hz (Bloch waves), inverse Fourier transform and "
        "Eq. (3) over Δt, so that the first value is half; what the band limit puts before t = 0 is lost. Right, thin: "
        "causal dynamics, a unit impulse through the ring of bays, with what it displaces at once. An ideal impulse "
        f"moves the rail by {1e6 * first_displacement(track):.2f} µm/(N s) at first, 1/(2 √(ρA κGA)). Summed up, the "
        f"paper's functions of the loaded rail lack {missing[0]:.0f} pm/N above a sleeper and {missing[1]:.0f} pm/N "
        "mid-bay of the causal ones."
    )
    with new_figure(6.6, title, made) as figure:
        axes = figure.subplots(2, 2, width_ratios=(1.1, 1))
        for row, rail in enumerate(CLOSE):
            for index, start in enumerate(STARTS):
                for pane, functions, end, look in (
                    (axes[row, 0], paper, time[-1], Look(f"{start}, paper", COLOURS[index], DASHES[index], 1.3)),
                    (axes[row, 1], paper, CLOSE[rail], Look("", COLOURS[index], DASHES[index], 2.2)),
                    (axes[row, 1], causal, CLOSE[rail], Look(f"{start}, causal", DARK[index], DASHES[index], 0.9)),
                ):
                    shown = time <= end + dt
                    style = {"color": look.colour, "linestyle": look.dashes, "linewidth": look.width}
                    values = 1e6 * functions[start][row] / dt
                    pane.plot(1e3 * time[shown], values[shown], label=look.name, **style)
                    pane.set_xlim(0, 1e3 * end)
            for pane in axes[row]:
                pane.axhline(0, color="#c8c8cc", linewidth=0.6, zorder=0)
                finish(pane, "" if pane is axes[row, 1] else f"{rail} (µm/(N s))")
                pane.set_xlabel("time (ms)")
                pane.locator_params(axis="x", nbins=6)
        for pane in axes[1]:
            pane.get_legend().remove()
        return drawing.save(out, "moving_green_functions", figure)


def first_displacement(track: Track) -> float:
    """Step of the rail's Green's function at t = 0, m/(N s): that of its shear wave, whatever lies below the rail."""
    return float(0.5 / np.sqrt(track.rail.rhoA * track.rail.kGA))


def ring_impulse(ring: TrackRing, speed: float, start: int, samples: int) -> Rails:
    """Response (samples,) in m/N of the causal dynamics' ring to 1 N at step ``start`` of a bay, and none later.

    The load rises and falls linearly over one step each (first-order hold), as in the coupled step.
    """
    dt = ring.dx / speed
    even, odd = (_half_impulse(half, speed, dt, start, samples) for half in (ring.symmetric, ring.antisymmetric))
    return Rails((even + odd) / 2, (even - odd) / 2)


def _half_impulse(half: HalfRing, speed: float, dt: float, start: int, samples: int) -> Real:
    poles = half.moving_poles(speed)
    before, after = hold_coefficients(poles, dt)
    factor = np.exp(poles * dt)
    load = half.input[start]
    places = (start + np.arange(samples)) % len(half.input)
    response = np.empty(samples)
    response[0] = (half.output[start] * after * load).real.sum() + half.residual[start]
    state = (factor * after + before) * load
    for n in range(1, samples):
        response[n] = (half.output[places[n]] * state).real.sum()
        state = state * factor
    return response
