"""Writes docs/validation.md and its figures from results, which are stored in results/validation.

python -m tools.validation        from the root; needs the test extra (make validation sees to it)
"""

from __future__ import annotations

import sys
from typing import Any

from . import contacts, hardness, impact, load_cases, ripple, steps, tracks, wheelset_checks, wheelsets
from .load_cases import printed
from .page import number, paragraphs, percent, table
from .store import ROOT

PAGE = ROOT / "docs" / "validation.md"


def main() -> int:
    """Compute what is missing, write the page; 1 if a package is missing."""
    missing = contacts.missing()
    if missing:
        print(f"{', '.join(missing)} not installed: run `python3 tools/setup_env.py test` first", file=sys.stderr)
        return 1
    cases = load_cases.runs()
    causal, paper = impact.runs(impact.CAUSAL), impact.runs(impact.AS_PRINTED)
    static = wheelset_checks.facts()["static"]
    sections = [
        load_cases.section(cases),
        impact.section(causal, paper, cases["undamaged"]),
        ripple.section(static[0]),
        contacts.section(),
        wheelsets.section(),
        tracks.section(),
        steps.section(),
        hardness.section(),
    ]
    PAGE.write_text(paragraphs(*_first(cases, causal, paper), *sections) + "\n", encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)} is written")
    return 0


def _first(cases: load_cases.Both, causal: impact.Found, paper: impact.Found) -> list[str]:
    smooth, hit = cases["undamaged"], cases["damage_wheel_1"]
    folded = {variant.changes: run for variant, run in paper}[("dynamics=paper", "lag_zero=folded")]
    x40 = wheelset_checks.facts()
    peaks = [run.largest[0] for _, run in causal + paper]
    low, high = number(min(peaks), 0), number(max(peaks), 0)

    def stress(case: int, runs: Any, node: int) -> list[Any]:
        reference = printed(case, "stress", node)
        assert reference is not None
        return [reference, runs[0].stress[node], runs[1].stress[node], percent(runs[0].stress[node], reference)]

    chosen, open_ = "agrees; chosen to (5)", "ripple (3); geometry (5)"
    rows = [
        ["mass of the wheelset, kg", 1943.0, x40["mass"], None, percent(x40["mass"], 1943), chosen],
        ["bending mode, Hz", 206.0, x40["bending"], None, percent(x40["bending"], 206), chosen],
        ["mode of A1, Hz", 1920.0, x40["strongest"], None, percent(x40["strongest"], 1920), chosen],
        ["case 2: A1, MPa", *stress(1, hit, 0), "agrees, as far as the geometry is known (5)"],
        ["case 2: B1, MPa", *stress(1, hit, 1), "agrees, as far as the geometry is known (5)"],
        ["case 2: C1, MPa", *stress(1, hit, 2), "within what the geometry leaves open (5)"],
        ["case 1: A1, MPa", *stress(0, smooth, 0), open_],
        ["case 1: B1, MPa", *stress(0, smooth, 1), open_],
        ["case 1: C1, MPa", *stress(0, smooth, 2), open_],
        _force("case 2: max force, wheel 1, kN", 1, 0, hit, f"{low} to {high} kN by what the band limit cuts off (2)"),
        _force("case 2: max force, wheel 2, kN", 1, 1, hit, "ripple (3)"),
        _force("case 1: max force, wheel 1, kN", 0, 0, smooth, "open: ripple at the sleepers (3)"),
        _force("case 1: max force, wheel 2, kN", 0, 1, smooth, "open: ripple at the sleepers (3)"),
    ]
    return [
        "# Validation",
        "What the numbers of this software are worth. `make validation` recomputes everything and writes this page and "
        "its figures; no result on it is typed by hand, and nothing was fitted to a force of the paper. Its geometry "
        "is not printed: ours, with the side of the gearbox on which B1 stands, was chosen knowing mass, frequencies "
        "and stresses, so that agreement of stresses is no blind test (5). "
        "*Printed* is M. Maglio, A. Pieringer, J. C. O. Nielsen and T. Vernersson, *Wheel–rail impact loads and axle "
        "bending stress simulated for generic distributions and shapes of discrete wheel tread damage*, whose sections "
        "and tables are quoted. *Causal* is the streaming dynamics, *paper* the paper's method as printed. Numbers in "
        "brackets are sections of this page.",
        table(("", "printed", "causal", "paper", "causal to printed", "verdict (section)"), rows),
        "Beside the paper: the two dynamics agree with each other where the paper's band limit is mended "
        f"({number(causal[0][1].largest[0])} and {number(folded.largest[0])} kN) and in smooth running; contact agrees "
        "with Hertz and with an independent half-space solver, wheelset with an independent brick model, track with "
        "closed forms and between finite elements and Bloch waves (4 to 7).",
    ]


def _force(label: str, case: int, wheel: int, runs: Any, verdict: str) -> list[Any]:
    reference = printed(case, "largest", wheel)
    assert reference is not None
    causal, paper = (run.largest[wheel] for run in runs)
    return [label, reference, causal, paper, percent(causal, reference), verdict]


if __name__ == "__main__":
    sys.exit(main())
