"""Section 7: step length, and force tables against the active set in every step."""

from __future__ import annotations

from .impact import largest_gap
from .page import number, paragraphs, table
from .runs import must, passage

CASE = "damage_wheel_1"


def section() -> str:
    """Text of the section."""
    rows = []
    for length in (0.002, 0.001, 0.0005):
        run = must(passage(CASE, [f"step_length={length}"]))
        rows.append([f"{length * 1e3:g} mm", *run.largest, run.smallest[1], run.loss[0], *run.stress, run.lowest[0]])
    tabled, solved = must(passage(CASE)), must(passage(CASE, tables=False))
    head = ("step", "max 1, kN", "max 2, kN", "min 2, kN", "lost 1, ms", "A1, MPa", "B1, MPa", "C1, MPa", "min A1, MPa")
    return paragraphs(
        "## 7. Steps and tables",
        "Case 2, causal. The step is also the length of a contact element, so this refines time and contact together:",
        table(head, rows, (0, 1, 1, 1, 2, 1, 1, 1, 1)),
        "Force tables against the active set solved in every step: over the passage forces differ by at most "
        f"{number(1e3 * largest_gap(tabled, solved), 1)} N, to the 0.1 N that are kept here "
        f"(peak {number(solved.largest[0], 3)} kN).",
    )
