"""First screen of the page: which numbers can be trusted, to how much, and where the paper differs and why."""

from __future__ import annotations

from typing import Any

from . import (
    bound,
    contacts,
    coupling,
    hardness,
    impact,
    joints,
    load_cases,
    railfe,
    steps,
    wheelset_checks,
    wheelsets,
)
from .load_cases import printed
from .page import exponent, number, percent, table


def screen(cases: load_cases.Both, causal: impact.Found, paper: impact.Found) -> list[str]:
    """Paragraphs of the first screen."""
    peaks = [run.largest[0] for _, run in causal + paper]
    low, high = number(min(peaks), 0), number(max(peaks), 0)
    return [
        "# Validation",
        "Which numbers of this software can you trust, and to how much? Where does the paper differ, and why? Numbers "
        "in brackets are sections of this page.",
        table(("number", "trust it to", "because (section)"), _trusted(low, high, causal + paper)),
        "Where the paper differs:",
        _differences(cases, low, high),
        table(("", "printed", "causal", "paper", "causal to printed", "verdict (section)"), _beside(cases, low, high)),
        "`make validation` recomputes everything and writes this page and its figures. No result on it is typed by "
        "hand but those of the paper and of railFE, and nothing was fitted to a force of the paper. "
        "*Printed* is M. Maglio, A. Pieringer, J. C. O. Nielsen and T. Vernersson, *Wheel–rail impact loads and axle "
        "bending stress simulated for generic distributions and shapes of discrete wheel tread damage*, whose sections "
        "and tables are quoted. *Causal* is the streaming dynamics, *paper* the paper's method as printed. The paper "
        "does not print the wheelset's geometry. Ours, with the side of the gearbox on which B1 stands, was chosen "
        "knowing mass, frequencies and stresses, so agreement of stresses is no blind test (5).",
    ]


def _trusted(low: str, high: str, variants: impact.Found) -> list[list[Any]]:
    stresses = [run.stress[0] for _, run in variants]
    among = 100 * (max(stresses) / min(stresses) - 1)
    hertz = [row for row in contacts.hertz() if row[1:3] == [1e-3, contacts.ELEMENT_WIDTH]]
    of_hertz, of_peak = (100 * max(abs(row[column]) for row in hertz) for column in (4, 5))
    of_space = max(row[3] for row in contacts.spaces())
    of_steps = [100 * each for each in steps.worst()]
    solid = wheelset_checks.compared_with_bricks()["static"]
    of_bricks = 100 * max(abs(ours / other - 1) for ours, other in solid)
    rises = [row[7] for name in joints.WHEELSETS for row in joints.rows_of(name)]
    gap = max(abs(ours - other) for ours, other in zip(railfe.ours(), railfe.OTHER, strict=True))
    below, above = coupling.worst(0, 900), coupling.worst(1200, 2000)
    share, of_force = hardness.flat()
    return [
        [
            "contact force and pressure of given surfaces and approach",
            f"force {number(of_hertz)} %, peak pressure {number(of_peak)} %",
            f"Hertz; another solver agrees to {exponent(of_space, 0)} with a defect in the patch (4)",
        ],
        [
            "pressure at sharp edges",
            "not at all without `contact.hardness`",
            f"elastic: above 2.6 GPa on {number(100 * share, 0)} % of the force of a fresh flat; a bound there takes "
            f"{number(100 * of_force)} % off the force (8)",
        ],
        [
            "force of long waves and of ripples, up to 900 Hz",
            f"{number(below, 0)} %",
            f"receptances, amplitude and phase; from 1200 to 2000 Hz {number(above, 0)} %; between, it depends on the "
            "place in the bay (9)",
        ],
        [
            "P2 force at a dipped joint",
            f"{number(max(abs(each) for each in rises), 0)} % of its rise",
            "a model of one mass; Jenkins' formula is above both (10)",
        ],
        ["force over a bump", f"{number(gap)} kN of {number(railfe.OTHER[0], 0)} kN", "railFE, a public code (11)"],
        [
            "peak force of an impact",
            f"{low} to {high} kN in case 2",
            "what happens within 0.2 ms of the landing, above 2500 Hz, decides it (2)",
        ],
        [
            "axle stress of a given wheelset",
            f"{number(of_bricks)} %, static",
            f"an independent model of bricks (5); the variants of section 2 differ by {number(among)} % at A1",
        ],
        [
            "axle stress of a wheelset without a drawing",
            f"{number(100 * wheelsets.spread(), 0)} %",
            "fillets, diameters and bearings that are not known (5)",
        ],
        [
            "axle stress beside strain gauges and limits",
            "with `loads: {own_weight: true}`",
            f"at 12 t static stresses are up to {number(100 * wheelsets.excess(), 0)} % too high without it (5)",
        ],
        [
            "anything below 15 Hz",
            "with a `vehicle`",
            "suspensions are held fixed without one; a run with such waves warns "
            "([wheelsets.md](reference/wheelsets.md#the-vehicle-above))",
        ],
        [
            "any of them, at the default step",
            f"force {number(of_steps[0])} %, stress {number(of_steps[1])} %, smallest force {number(of_steps[2])} %",
            "half the step, from 5 to 100 m/s (7)",
        ],
    ]


def _differences(cases: load_cases.Both, low: str, high: str) -> str:
    smooth, hit = cases["undamaged"][0], cases["damage_wheel_1"][0]
    at_100 = next(row for row in bound.bounds() if row["speed"] == 100)
    ripple, hits = (number(printed(case, "largest", 0), 0) for case in (0, 1))
    return "\n".join(
        [
            f"* **The ripple at the sleepers**: printed {ripple} kN, ours {number(smooth.largest[0])} kN. With the "
            f"printed track no wheelset can exceed ±{number(at_100['bound'])} kN at 100 km/h. So {ripple} kN does not "
            "follow from the printed data (3).",
            f"* **The impact**: printed {hits} kN, ours {number(hit.largest[0], 0)} kN. It is the same deviation: a "
            "wheel that carries the printed ripple when it meets the defect lands as hard as printed (3). The method "
            f"itself leaves {low} to {high} kN open, by what its band limit cuts off (2).",
            "* **Stresses at C1, and without damage**: within what the geometry leaves open, which is not printed (5).",
        ]
    )


def _beside(cases: load_cases.Both, low: str, high: str) -> list[list[Any]]:
    smooth, hit = cases["undamaged"], cases["damage_wheel_1"]
    x40 = wheelset_checks.facts()

    def stress(case: int, runs: Any, node: int) -> list[Any]:
        reference = printed(case, "stress", node)
        assert reference is not None
        return [reference, runs[0].stress[node], runs[1].stress[node], percent(runs[0].stress[node], reference)]

    chosen, open_ = "agrees; chosen to (5)", "ripple (3); geometry (5)"
    return [
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
        _force("case 1: max force, wheel 1, kN", 0, 0, smooth, "does not follow from the printed data (3)"),
        _force("case 1: max force, wheel 2, kN", 0, 1, smooth, "does not follow from the printed data (3)"),
    ]


def _force(label: str, case: int, wheel: int, runs: Any, verdict: str) -> list[Any]:
    reference = printed(case, "largest", wheel)
    assert reference is not None
    causal, paper = (run.largest[wheel] for run in runs)
    return [label, reference, causal, paper, percent(causal, reference), verdict]
