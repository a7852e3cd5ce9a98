"""Fig. 7: receptances of the rails above a sleeper and in the middle of a bay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from ..report.figures import COLOURS, new_figure
from ..runtime.arrays import Complex, Real
from ..runtime.progress import Progress, unreported
from ..scenario import Scenario
from ..track import bloch
from ..track import finite_elements as track_fe
from ..track.track import Track
from . import drawing
from .drawing import Look

LOWEST = 10.0
"""Hz; the receptance hardly changes below."""
SPACING = 0.5
"""Hz; the pinned-pinned resonance is some ten times as wide."""
ELEMENTS = 60
"""Frequencies at which the finite elements stand beside the waves."""
SPAN = (2e-13, 1.5e-7)
"""Receptances that are drawn, m/N: the rails hardly couple below."""

MID_BAY = "mid-bay"
DIRECT, CROSS = Look("loaded rail (direct)", COLOURS[0]), Look("opposite rail (cross)", COLOURS[1])


@dataclass(frozen=True)
class Feature:
    """A frequency that the direct receptance is known by."""

    name: str
    place: str
    frequency: float
    """Hz."""
    magnitude: float
    """m/N."""


def draw(out: Path, scenario: Scenario, progress: Progress | None = None) -> list[Path]:
    """Write ``track_receptances``, and in tables the finite elements beside it and its resonances, into ``out``.

    Raises InputError for a track that cannot be used, and for a folder that cannot be written.
    """
    track, report = scenario.track, progress or unreported
    limit = drawing.band(scenario)
    places = {"above a sleeper": 0.0, MID_BAY: track.spacing / 2}
    frequencies = np.union1d(np.geomspace(LOWEST, limit, 1000), np.arange(LOWEST, limit, SPACING))
    few = np.geomspace(LOWEST, limit, ELEMENTS)
    with_statics = np.concatenate([[0.0], frequencies])

    waves: dict[str, Complex] = {}
    elements: dict[str, Complex] = {}
    for number, (place, x) in enumerate(places.items()):
        report("track receptances", number / len(places))
        waves[place] = np.concatenate(bloch.receptance(track, with_statics, x, x))
        elements[place] = np.concatenate(track_fe.receptance(track, few, x, x))
    features = [
        feature
        for place, curves in waves.items()
        for feature in features_of(track, place, frequencies, np.abs(curves[0, 1:]))
    ]
    paths = _figure(out, track, frequencies, waves, few, elements, features)
    beside = {place: np.concatenate(bloch.receptance(track, few, x, x)) for place, x in places.items()}
    report("track receptances", 1.0)
    return [
        *paths,
        drawing.table(out, "track_receptances", {"frequency (Hz)": with_statics} | _columns(waves)),
        drawing.table(
            out,
            "track_receptances_by_finite_elements",
            {"frequency (Hz)": few} | _columns(elements, "finite elements, ") | _columns(beside, "Bloch waves, "),
        ),
        _feature_table(out, features),
    ]


def pinned_pinned(track: Track) -> float:
    """Frequency (Hz) of a Timoshenko beam pinned at two sleepers, half a wave long: lower root of its closed form.

    ``(EI k^2 + kGA - rhoI w^2)(kGA k^2 - rhoA w^2) = (kGA k)^2`` with ``k = pi / spacing``.
    """
    rail, k = track.rail, np.pi / track.spacing
    turning = rail.EI * k**2 + rail.kGA
    a, b = rail.rhoI * rail.rhoA, rail.rhoI * rail.kGA * k**2 + rail.rhoA * turning
    c = rail.kGA * k**2 * turning - (rail.kGA * k) ** 2
    return float(np.sqrt((b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)) / (2 * np.pi))


def features_of(track: Track, place: str, frequencies: Real, magnitude: Real) -> list[Feature]:
    """Track resonance, anti-resonance, rail on pads, and mid-bay the pinned-pinned resonance: those in the band."""
    (peaks, heights), (dips, depths) = _maxima(frequencies, magnitude), _maxima(frequencies, -magnitude)
    pinned = pinned_pinned(track)
    found = [Feature("track resonance", place, *peak) for peak in zip(peaks[:1], heights[:1], strict=True)]
    after = np.flatnonzero(dips > peaks[:1].sum())
    found += [Feature("anti-resonance", place, dips[at], -depths[at]) for at in after[:1]]
    second = np.flatnonzero(peaks < 0.7 * pinned)[1:2]
    found += [Feature("rail on pads", place, peaks[at], heights[at]) for at in second]
    near = np.flatnonzero((np.abs(peaks / pinned - 1) < 0.05) & (place == MID_BAY))
    return found + [Feature("pinned–pinned", place, peaks[at], heights[at]) for at in near[:1]]


def _maxima(x: Real, values: Real) -> tuple[Real, Real]:
    """Local maxima: places and values of the parabolas through three samples each."""
    at = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
    before, after = x[at - 1] - x[at], x[at + 1] - x[at]
    left, right = (values[at - 1] - values[at]) / before, (values[at + 1] - values[at]) / after
    curvature = (right - left) / (after - before)
    slope = left - curvature * before
    return x[at] - slope / (2 * curvature), values[at] - slope**2 / (4 * curvature)


def _figure(
    out: Path,
    track: Track,
    frequencies: Real,
    waves: dict[str, Complex],
    few: Real,
    elements: dict[str, Complex],
    features: Sequence[Feature],
) -> list[Path]:
    title = f"Track {track.name}: receptances of the rails"
    static = " and ".join(f"{1e9 * curves[0, 0].real:.2f} nm/N {place}" for place, curves in waves.items())
    made = (
        f"Lines: Bloch waves of the infinite track, exact, as in the paper dynamics; the causal dynamics' ring has the "
        f"same track's modes. Circles: finite elements, {track_fe.BAYS} bays with clamped ends, "
        f"{track.rail.elements_per_bay} rail elements a bay (Section 4). Static direct: {static}."
    )
    with new_figure(6.6, title, made) as figure:
        axes = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=(3, 2))
        for column, (place, curves) in enumerate(waves.items()):
            pair = axes[:, column]
            curves_by_look = {DIRECT: curves[0, 1:], CROSS: curves[1, 1:]}
            drawing.over_frequency(pair, frequencies, curves_by_look, "receptance (m/N)")
            for look, response in zip((DIRECT, CROSS), elements[place], strict=True):
                style = {"color": look.colour, "linestyle": "", "marker": "o", "markersize": 3.2, "fillstyle": "none"}
                pair[0].plot(few, np.abs(response), markeredgewidth=0.7, **style)
                pair[1].plot(few, drawing.phase_degrees(response), markeredgewidth=0.7, **style)
            pair[0].annotate(place, (0.03, 0.05), xycoords="axes fraction", fontsize=11)
            for feature in features:
                if feature.place == place:
                    _label(pair[0], feature)
        axes[0, 0].set_ylim(SPAN)
        for each in axes[:, 1]:
            each.set_ylabel("")
        axes[0, 1].get_legend().remove()
        return drawing.save(out, "track_receptances", figure)


def _label(axes: Axes, feature: Feature) -> None:
    below = feature.name == "anti-resonance"
    axes.annotate(
        f"{feature.name}{' ' if below else chr(10)}{feature.frequency:.0f} Hz",
        (feature.frequency, feature.magnitude),
        xytext=(-22, -9) if below else (0, 12),
        textcoords="offset points",
        ha="center",
        va="top" if below else "bottom",
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "color": "#888888", "linewidth": 0.7},
    )


def _columns(curves: dict[str, Complex], by: str = "") -> dict[str, Real]:
    columns = {}
    for place, pair in curves.items():
        for name, response in zip(("direct", "cross"), pair, strict=True):
            columns[f"{by}{name} {place} magnitude (m/N)"] = np.abs(response)
            columns[f"{by}{name} {place} phase (deg)"] = drawing.phase_degrees(response)
    return columns


def _feature_table(out: Path, features: Sequence[Feature]) -> Path:
    columns: dict[str, Sequence[str] | Sequence[float]] = {
        "feature": [feature.name for feature in features],
        "place": [feature.place for feature in features],
        "frequency (Hz)": [feature.frequency for feature in features],
        "direct magnitude (m/N)": [feature.magnitude for feature in features],
    }
    return drawing.table(out, "track_receptances_features", columns)
