"""Section 6: the track by two methods and against closed forms; what the paper leaves open."""

from __future__ import annotations

from functools import partial
from typing import Any

from .page import exponent, paragraphs, table
from .runs import Passage, must, passage
from .track_checks import (
    BANDS,
    RINGS,
    TRACK,
    ballast,
    even_springs,
    methods,
    pinned_pinned,
    resonances,
    rings,
    tamped,
    with_ring,
)


def _open() -> list[tuple[str, Passage, Passage]]:
    """What the paper leaves open: label, passage without and with damage."""
    cases: list[tuple[str, dict[str, Any]]] = [("as shipped", {})]
    cases += [(f"sleeper length {length} m", {"changes": [f"track.sleeper.length={length}"]}) for length in (2.4, 2.6)]
    for label, law in (("ballast: equal springs at the nodes", even_springs), ("ballast: none within 0.4 m", tamped)):
        cases.append((label, {"within": partial(ballast, law), "key": law.__name__}))
    for bays, limit in RINGS:
        if (bays, limit) != (80, 5000.0):
            label = f"ring of {bays} bays, modes to {limit / 1e3:g} kHz"
            cases.append((label, {"alter": partial(with_ring, bays, limit), "key": [bays, limit]}))
    for variant in ("wheel_residual", "zero"):
        cases.append((f"lag zero: `{variant}`", {"changes": [f"lag_zero={variant}"]}))
    return [(label, must(passage("undamaged", **how)), must(passage("damage_wheel_1", **how))) for label, how in cases]


def section() -> str:
    """Text of the section."""
    known, compared = resonances(), methods()
    closed = pinned_pinned(TRACK)
    facts = [
        ["static direct receptance above a sleeper, 10⁻⁸ m/N", known["static"][0] * 1e8],
        ["static cross receptance above a sleeper, 10⁻⁸ m/N", known["static"][1] * 1e8],
        ["static direct receptance mid-bay, 10⁻⁸ m/N", known["static"][2] * 1e8],
    ]
    peaks = [
        ["track on ballast", known["above"][0]],
        ["antiresonance above a sleeper", known["above_low"]],
        ["antiresonance mid-bay", known["middle_low"]],
        ["rail on pads", known["above"][1]],
        ["pinned-pinned, mid-bay", known["middle"][2]],
        ["pinned-pinned without rotational pad springs", known["pinned"]],
        ["closed form: simply supported Timoshenko beam of 0.6 m", closed],
    ]
    runs = [
        [label, smooth.largest[0], smooth.largest[1], hit.largest[0], hit.largest[1], hit.smallest[1], *hit.stress]
        for label, smooth, hit in _open()
    ]
    head = ("", "case 1: max 1, kN", "max 2, kN", "case 2: max 1, kN", "max 2", "min 2", "A1, MPa", "B1", "C1")
    return paragraphs(
        "## 6. Track",
        "The paper shows receptances (Fig. 7) but prints no numbers of them; these are ours, from exact Bloch waves:",
        table(("statics", ""), facts, (0, 4)),
        table(("frequency, Hz", ""), peaks, (0, 2)),
        "Finite elements (140 bays, clamped ends: the paper's model) against Bloch waves (infinite track), load "
        f"mid-bay, responses to 2.7 m away on both rails, as part of the largest receptance. Statics agree to "
        f"{exponent(compared['static'])} at any place; the error of the elements falls with their square:",
        table(
            ("elements a bay", "below 300 Hz", "at 1500 Hz", "to 2500 Hz"),
            [[str(n), *(exponent(e) for e in errors)] for n, *errors in compared["elements"]],
        ),
        "The ring that `causal` runs on (default: 80 bays, modes to 5 kHz) against Bloch waves: largest difference of "
        "the direct and cross receptances at three places, as part of the direct one, %. Between 1000 and 1150 Hz it "
        "is the tip of the pinned-pinned peak, whose wave comes round the ring:",
        table(
            ("ring", *(f"{low}–{high} Hz" for low, high in BANDS)),
            [[f"{bays} bays, {limit / 1e3:g} kHz", *(100 * e for e in errors)] for bays, limit, *errors in rings()],
            2,
        ),
        "**What the open assumptions and our own choices move** (causal; cases 1 and 2):",
        table(head, runs, (0, 2, 2, 1, 1, 1, 1, 1, 1)),
        "The ballast is shared by tributary length unless said otherwise. Rotational pad springs are grounded.",
    )
