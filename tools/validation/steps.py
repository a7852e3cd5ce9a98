"""Section 7: step length, and force tables against the active set in every step."""

from __future__ import annotations

from collections.abc import Callable

from .impact import largest_gap
from .page import number, paragraphs, percent, table
from .runs import Passage, must, passage

CASE = "damage_wheel_1"
SPEEDS = (5.0, 10.0, 20.0, 27.7777778, 40.0, 55.0, 75.0, 100.0)
"""m/s"""
LENGTHS = (0.002, 0.001, 0.0005)
"""m; the second is the default."""


def section() -> str:
    """Text of the section."""
    rows = []
    for length in LENGTHS:
        run = must(passage(CASE, [f"step_length={length}"]))
        rows.append([f"{length * 1e3:g} mm", *run.largest, run.smallest[1], run.loss[0], *run.stress, run.lowest[0]])
    tabled, solved = must(passage(CASE)), must(passage(CASE, tables=False))
    head = ("step", "max 1, kN", "max 2, kN", "min 2, kN", "lost 1, ms", "A1, MPa", "B1, MPa", "C1, MPa", "min A1, MPa")
    return paragraphs(
        "## 7. Steps and tables",
        "Case 2, causal. The step is also the length of a contact element, so this refines time and contact together:",
        table(head, rows, (0, 1, 1, 1, 2, 1, 1, 1, 1)),
        _over_speed(),
        "Force tables against the active set solved in every step: over the passage forces differ by at most "
        f"{number(1e3 * largest_gap(tabled, solved), 1)} N, to the 0.1 N that are kept here "
        f"(peak {number(solved.largest[0], 3)} kN).",
    )


def _at(speed: float) -> list[Passage]:
    """Passages with steps of 2, 1 and 0.5 mm."""
    return [must(passage(CASE, [f"speed={speed}", f"step_length={length}"])) for length in LENGTHS]


KEPT: tuple[Callable[[Passage], float], ...] = (
    lambda run: run.largest[0],
    lambda run: run.stress[0],
    lambda run: run.smallest[1],
)
"""Largest force of wheel 1, kN, largest stress at A1, MPa, smallest force of wheel 2, kN."""


def worst() -> tuple[float, ...]:
    """Largest change by halving the default step, over all speeds, of each that is KEPT: shares."""
    pairs = [_at(speed)[1:] for speed in SPEEDS]
    return tuple(max(abs(of(usual) / of(fine) - 1) for usual, fine in pairs) for of in KEPT)


def _over_speed() -> str:
    """The same at other speeds: values of the finest step, and how far the coarser ones are from them."""
    rows = []
    for speed in SPEEDS:
        coarse, usual, fine = _at(speed)
        row: list[str | float] = [f"{speed:.3g} m/s"]
        for of in KEPT:
            row += [of(fine), percent(of(usual), of(fine), 2), percent(of(coarse), of(fine), 2)]
        rows.append(row)
    head = ("speed", "max 1, kN", "1 mm", "2 mm", "max A1, MPa", "1 mm", "2 mm", "min 2, kN", "1 mm", "2 mm")
    return paragraphs(
        "Over speed, with steps of 0.5 mm, and how far steps of 1 mm (the default) and of 2 mm are from them. Wheel 2 "
        "has no defect; its smallest force is the answer of the axle to the impact on the other side:",
        table(head, rows, (0, 1, 0, 0, 1, 0, 0, 1, 0, 0)),
    )
