"""Writes the lateral profiles that are shipped as points into ``config``: ``python tools/shipped_profiles.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.contact import RailHead
from wheelset_track_sim.contact.profiles import inclined

CONFIG = Path(__file__).resolve().parents[1] / "config"
Real = NDArray[np.float64]

S1002_TREAD = (0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8)
S1002_TREAD += (-1.562379023e-8, 5.309217349e-15, -5.957839843e-12, 2.646656573e-13)
S1002_ROOT = (-4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1)
S1002_ROOT += (-4.169739389e-3, -4.687195829e-5, -2.252755540e-7)


def s1002(y: Real) -> Real:
    """S1002 of EN 13715 with a flange 28 mm high, sections A to H from the field side; y and height in mm."""

    def arc(height: float, radius: float, centre: float, side: float = 1.0) -> Real:
        return height + side * np.sqrt(np.maximum(radius**2 - (y - centre) ** 2, 0.0))

    ends = (32.15796, -26.0, -35.0, -38.426669071, -39.764473993, -49.662510381, -62.764705882)
    return np.select(
        [y > end for end in ends],
        [
            1.364323640 - y / 15,
            np.polynomial.polynomial.polyval(y, S1002_TREAD),
            np.polynomial.polynomial.polyval(y, S1002_ROOT),
            arc(16.446, 13.0, -26.210665, -1.0),
            -93.576667419 - 2.747477419 * y,
            arc(8.834924130, 20.0, -58.558326413),
            arc(16.0, 12.0, -55.0),
        ],
        arc(9.519259302, 20.5, -49.5),
    )


def hollow(y: Real, depth: float = 1.5, wander: float = 5.0) -> Real:
    """S1002 worn ``depth`` mm hollow by rails 60E1, 1:40, 3.5 mm outside, that wander to either side; all in mm.

    Made up: no wheel was measured. What overlaps a rail that is pressed in, at any place up to ``wander`` mm from the
    middle, is taken off; the edges are rounded over 3 mm.
    """
    rail, fine = inclined(RailHead(), 1 / 40), np.arange(-90.0, 90.01, 0.1)
    middle = 3.5  # of the head, from the rolling circle
    places = middle + np.arange(-wander, wander + 0.05, 0.1)
    removed = np.stack([-1e3 * rail.height(1e-3 * (fine - place)) for place in places]).min(axis=0)
    new = s1002(fine)
    near = np.abs(fine) < 30.0
    overlap = np.maximum(new - removed - (new - removed)[near].max() + depth, 0.0)
    overlap[~np.isfinite(overlap)] = 0.0
    weight = np.exp(-0.5 * (np.arange(-9.0, 9.01, 0.1) / 3.0) ** 2)
    worn = np.convolve(overlap, weight / weight.sum(), "same")
    return s1002(y) - np.interp(y, fine, worn)


def write(kind: str, name: str, y: Real, z: Real, about: str) -> None:
    """One file: what it is in lines with ``#``, then the points, in mm to a tenth of a micrometre."""
    path = CONFIG / kind / f"{name}.csv"
    path.parent.mkdir(exist_ok=True)
    points = "".join(f"{a:.3f},{b:.4f}\n" for a, b in zip(y, z + 0.0, strict=True))
    path.write_text("".join(f"# {line}\n" for line in about.splitlines()) + "y_mm,z_mm\n" + points, encoding="utf-8")


def main() -> None:
    """Write all."""
    y = np.round(np.arange(-69.0, 60.01, 0.25), 3)
    outwards = "y from the rolling circle to the field side, z what the radius is larger than there"
    flange = "S1002 of EN 13715, flange 28 mm high and 32.5 mm thick: points of its sections A to H, exact"
    write("wheel_profiles", "s1002", y, s1002(y), f"{flange}.\n{outwards}.")
    noise = 0.002 * np.random.default_rng(1002).standard_normal(len(y))
    write(
        "wheel_profiles",
        "s1002_hollow",
        y,
        np.round(hollow(y) + noise, 3),
        "S1002 worn hollow. Synthetic, no wheel was measured: a new profile from which rails 60E1, 1:40, that\n"
        "wander 5 mm take 1.5 mm; with noise of 2 um like that of a profile gauge (tools/shipped_profiles.py).\n"
        f"{outwards}.",
    )
    half = np.append(np.arange(0.25, 35.8, 0.25), [35.9, 36.0])
    y = np.concatenate([-half[::-1], [0.0], half])
    write(
        "rail_profiles",
        "head_60e1_points",
        y,
        1e3 * RailHead().height(np.clip(1e-3 * y, -0.036, 0.036)),
        "Head of 60E1, EN 13674-1: points of its arcs R300, R80 and R13, exact. head_60e1 is computed.\n"
        "y from the middle of the head to the field side, z upwards from the top.",
    )


if __name__ == "__main__":
    main()
