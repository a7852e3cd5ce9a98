"""Section 5: the wheelset against the paper's facts, a finer mesh, bricks, statics; and what other geometries do."""

from __future__ import annotations

from typing import Any

import numpy as np

from .page import exponent, number, paragraphs, table
from .runs import must, passage
from .wheelset_checks import LOAD, compared_with_bricks, elements, facts, fine, own_weight

GEOMETRIES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("as shipped", ()),
    ("web thickness + 10 %", ("wheel.web_thickness_hub=0.05335", "wheel.web_thickness_rim=0.0385")),
    ("web thickness − 10 %", ("wheel.web_thickness_hub=0.04365", "wheel.web_thickness_rim=0.0315")),
    ("rim 5 mm thinner", ("wheel.rim_radius=0.398",)),
    ("body + 2 mm on both sides of the gearbox", ("axle.sections.3.diameter=0.182", "axle.sections.5.diameter=0.186")),
    ("fillet at A1 and C1: R40 → R30", ("axle.sections.2.fillet=0.030", "axle.sections.5.fillet=0.030")),
    ("fillet at A1 and C1: R40 → R60", ("axle.sections.2.fillet=0.060", "axle.sections.5.fillet=0.060")),
    ("axle boxes 20 mm further out", ("axle_boxes.distance=1.0475",)),
    ("axle boxes' bearing 80 → 40 mm", ("axle_boxes.bearing_length=0.040",)),
    ("gearbox 10 mm nearer to the middle", ("gearbox.y=0.393",)),
    ("no brake discs", ("brake_discs=null",)),
)


def spread() -> float:
    """Largest change of a stress of case 2 by what is not known of the geometry, brake discs left aside: a share."""
    shipped, *others = (_geometry(label, changes)[-3:] for label, changes in GEOMETRIES[:-1])
    return max(abs(stress / usual - 1) for other in others for stress, usual in zip(other, shipped, strict=True))


def section() -> str:
    """Text of the section."""
    x40, finer, solid, plain = facts(), fine(), compared_with_bricks(), elements()
    names = ("A1", "B1", "C1")
    section_modulus = np.pi * 0.180**3 / 32
    nominal = LOAD * (1.0275 - 0.750) / section_modulus / 1e6
    rows: list[list[Any]] = [
        ["mass with axle boxes, kg", "1943 (Section 3)", x40["mass"], finer["mass"]],
        ["bounce and roll on the suspension, Hz", None, _pair(x40["first"]), _pair(finer["first"])],
        ["bending mode of Fig. 12(a), Hz", "206 (Section 5.1)", x40["bending"], finer["bending"]],
        ["mode of A1 near 1920 Hz, Hz", "1920 (Section 5.1)", x40["strongest"], finer["strongest"]],
        *(
            [f"static maximum principal stress, {name}, MPa", None, x40["static"][i], finer["static"][i]]
            for i, name in enumerate(names)
        ),
    ]
    statics = [[name, x40["static"][i], plain[i], *solid["static"][i][::-1]] for i, name in enumerate(names)]
    modes = [[f"n = {n}", count, highest, exponent(gap)] for n, count, highest, gap in solid["modes"]]
    return paragraphs(
        "## 5. Wheelset",
        "The paper prints no drawing. The shipped geometry is one of many that meet the mass and the two frequencies "
        "that it does print; diameters, fillets and the places of axle boxes and gearbox are assumptions, and the last "
        "table of this section says what they move. The stresses of section 1 are to be read with that in mind.",
        table(("", "printed", "ours", "mesh halved"), rows, (0, 0, 1, 1)),
        f"Beam theory without the notch, on the 180 mm body: {number(nominal)} MPa; the fillet raises it at A1 by "
        f"{number(100 * (x40['static'][0] / nominal - 1), 0)} %. The reduced model has {x40['modes']} poles to 6 kHz; "
        f"the stress that it keeps as static residual is {number(100 * x40['stress_residual'], 2)} % of the static "
        f"stress, the displacement at the contacts that it leaves out "
        f"{number(x40['residual'][0] * 1e10, 2)}·10⁻¹⁰ m/N (the finite elements' own, which depends on the mesh).",
        "Statics: reduced model, finite elements on the same mesh; and, on a coarser mesh, 20-node bricks "
        f"({solid['unknowns']} unknowns, half of the wheelset, independent code) beside the harmonic elements. MPa, "
        "98.1 kN on both wheels:",
        table(("", "reduced", "finite elements", "bricks", "harmonics on their mesh"), statics, 2),
        "Modes of the harmonics cos(nθ) against those of the bricks, largest relative difference:",
        table(("harmonic", "modes", "up to, Hz", "difference"), modes, (0, 0, 0, 0)),
        *_own_weight(),
        "**What the open geometry moves** (case 2, causal):",
        table(
            (
                "geometry",
                "mass, kg",
                "bending, Hz",
                "static A1, MPa",
                "B1",
                "C1",
                "max 1, kN",
                "max A1, MPa",
                "B1",
                "C1",
            ),
            [_geometry(label, changes) for label, changes in GEOMETRIES],
            1,
        ),
    )


def excess() -> float:
    """What static stresses of the X40 are too high at 12 t without own weight: a share."""
    return max(float(without / within - 1) for without, within in zip(*own_weight()["x40"]["12"], strict=True))


def _own_weight() -> list[str]:
    weighed = own_weight()
    x40, ours, bricks = weighed["x40"], weighed["trailer"]["14"], weighed["trailer_calculix"]["14"]
    nodes = ("A1", "B1", "C1")
    rows = [[f"{load} t", *(part for pair in zip(*x40[load], strict=True) for part in pair)] for load in ("20", "12")]
    weights = [[without - within for without, within in zip(*each, strict=True)] for each in (ours, bricks)]
    return [
        "**Own weight.** Wheels, discs and axle carry themselves, so the journals carry the axle load less their "
        "weight. The paper lets them carry all of it, and so do the scenarios of the paper here; "
        "`loads: {own_weight: true}` superposes the difference, a constant stress of gravity alone. Static maximum "
        "principal stresses of the X40, MPa; without own weight they are up to "
        f"{number(100 * excess(), 0)} % too high at 12 t:",
        table(("axle load", *(f"{node}{end}" for node in nodes for end in ("", " with own weight"))), rows),
        "`tests/validation/test_static_bending.py` holds it within 2 % of a beam that carries wheels, gearbox and "
        "itself, and within 0.5 % far from hubs. At the nodes A1, A2, B1, B2 and M of the trailer, own weight lowers "
        f"the stress by {', '.join(number(value) for value in weights[1])} MPa in CalculiX with its own "
        f"bricks, and by {', '.join(number(value) for value in weights[0])} MPa in the harmonic elements.",
    ]


def _geometry(label: str, changes: tuple[str, ...]) -> list[Any]:
    found = facts(changes)
    run = must(passage("damage_wheel_1", [f"wheelset.{change}" for change in changes]))
    return [label, found["mass"], found["bending"], *found["static"], run.largest[0], *run.stress]


def _pair(frequencies: list[float]) -> str:
    return " and ".join(number(f) for f in frequencies[:2])
