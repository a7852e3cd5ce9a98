"""A comparison in words and cells for people: kN, MPa, ms, %."""

from __future__ import annotations

import math

from .comparison import WHEELS, Comparison


def rows(found: Comparison) -> list[tuple[str, ...]]:
    """Label and a cell for each signal: kN, MPa, %."""
    scales = [(1e3, "kN") if name in WHEELS else (1e6, "MPa") for name in found.names]
    lines: list[tuple[str, ...]] = []
    for label, field in (
        ("max, measured", "max_measured"),
        ("max, simulated", "max_simulated"),
        ("peak error", "peak_error"),
        ("mean error", "mean_error"),
        ("RMS error", "rms_error"),
    ):
        values = [getattr(each, field) / scale for each, (scale, _) in zip(found.measures, scales, strict=True)]
        lines.append((label, *(f"{value:.2f} {unit}" for value, (_, unit) in zip(values, scales, strict=True))))
    for label, field in (
        ("RMS error / RMS measured", "relative_error"),
        ("magnitude error (Sprague, Geers)", "magnitude_error"),
        ("phase error (Sprague, Geers)", "phase_error"),
        ("comprehensive error (Russell)", "russell_comprehensive_error"),
    ):
        lines.append((label, *(f"{100 * getattr(each, field):.1f} %" for each in found.measures)))
    lines.append(("correlation", *(f"{each.correlation:.4f}" for each in found.measures)))
    lines.append(("gain, measured / simulated", *(f"{each.gain:.3f}" for each in found.measures)))
    return lines


def impact_rows(found: Comparison) -> list[tuple[str, ...]]:
    """Cells of each impact, for people."""

    def force(value: float) -> str:
        return "none" if math.isnan(value) else f"{value / 1e3:.1f} kN"

    return [
        (
            f"{pair.at:.4f} {found.unit}",
            pair.signal.removeprefix("wheel_"),
            force(pair.measured),
            force(pair.simulated),
            "" if math.isnan(pair.error) else f"{100 * pair.error:+.1f} %",
        )
        for pair in found.impacts
    ]


def remarks(found: Comparison) -> list[str]:
    """What to know about the comparison, in lines."""
    second = "" if math.isnan(found.quality.second) else f", {found.quality.second:.3f} at any other lag"
    scale, unit = (1e3, "ms") if found.axis == "time" else (1e3, "mm")
    lines = [
        f"Zero of the measurement is at {found.lag:.6f} {found.unit} of the simulation (standard deviation "
        f"{scale * found.uncertainty:.2g} {unit}): correlation {found.quality.coefficient:.4f} there{second}.",
        f"Compared over {found.at[0]:.4f} to {found.at[-1]:.4f} {found.unit} with a sample each "
        f"{scale * found.step:.4g} {unit}, in the band of the slower of the two.",
    ]
    if found.left_out:
        lines.append(f"Not in the simulation, and left out: {', '.join(found.left_out)}.")
    return lines
