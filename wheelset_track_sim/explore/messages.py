"""Messages from the server to a page: a header in JSON, and arrays of numbers behind it."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..runtime.arrays import Real
from ..samples.impacts import ImpactSettings
from ..scenario import WHEELS
from ..verdict.limit_set import load_limits
from ..verdict.verdicts import verdicts
from .answers import Answer, Moment
from .plots import LIMITS, NODES
from .view import KINDS, SLIDERS, View

IMPACT = ImpactSettings().threshold
"""Contact force that makes an impact, N."""
ALIGNED = 4
"""Bytes: arrays begin at multiples of it, as the browser wants them."""
MARGIN = 3
"""Elements that are shown around the contact."""
CLOSEST = 12.0
"""Least half extent of the map of pressures, mm."""


def packed(header: Mapping[str, Any], arrays: Mapping[str, Real] | None = None) -> bytes:
    """One binary message: the length of the header as uint32, the header with names and lengths, float32 arrays."""
    found = {name: np.ascontiguousarray(array, np.float32) for name, array in (arrays or {}).items()}
    sizes = {name: array.size for name, array in found.items()}
    text = json.dumps({**header, "arrays": sizes}, allow_nan=False).encode()
    text += b" " * (-len(text) % ALIGNED)
    return b"".join([struct.pack("<I", len(text)), text, *(array.tobytes() for array in found.values())])


def answer_message(number: int, answer: Answer, pin: int | None = None) -> bytes:
    """Curves of an answer in kN, MPa and m, and what the page reads out; of a pinned one the two curves it shows."""
    forces, stresses = answer.block.forces / 1e3, getattr(answer, answer.view.stress) / 1e6
    arrays = {"place": answer.position}
    if pin is not None:
        worst = int(answer.amplitude.argmax())
        arrays |= {"force": forces[:, answer.wheel], "stress": stresses[:, worst]}
        words = f"{answer.nodes[worst]}, {answer.amplitude[worst] / 1e6:.0f} MPa"
        peak = forces[:, answer.wheel].max()
        header = {"kind": "pin", "number": number, "pin": pin, "words": f"{peak:.0f} kN; {words}"}
        return packed(header | {"query": answer.view.query(), "title": title(answer.view)}, arrays)
    nodes = answer.nodes[:NODES]
    arrays |= {f"force{wheel}": forces[:, wheel] for wheel in range(2)}
    arrays |= {f"stress{node}": stresses[:, node] for node in range(len(nodes))}
    header = {
        "kind": "answer",
        "number": number,
        "query": answer.view.query(),
        "nodes": nodes,
        "bay": answer.scenario.track.spacing,
        "row": answer.peak_row,
        "readouts": readouts(answer),
        **judged(answer),
        "seconds": answer.seconds,
    }
    return packed(header, arrays)


def judged(answer: Answer) -> dict[str, Any]:
    """Verdicts on an answer, the forces that are marked in its plot, and the sources of the limits."""
    limits = load_limits(answer.view.limits)
    marks: list[tuple[float, str]] = [(IMPACT / 1e3, f"{IMPACT / 1e3:.0f} kN, impact")]
    found: list[dict[str, str]] = []
    sources: list[str] = []
    if limits is not None:
        amplitudes = dict(zip(answer.nodes, answer.amplitude.tolist(), strict=True))
        peaks = answer.block.forces.max(axis=0).tolist()
        compared = verdicts(limits, peaks, answer.scenario.irregularities, amplitudes)
        found = [{"words": each.text, "level": each.level.word} for each in compared]
        marks += [(limit.above / 1e3, f"{limit.above / 1e3:.0f} kN, {limit.level}") for limit in limits.force]
        of_all = (*limits.force, *limits.damage_length, *limits.axle)
        sources = [*dict.fromkeys(limit.source for limit in of_all)]
    return {"marks": marks[:LIMITS], "verdicts": found, "sources": sources}


def title(view: View) -> str:
    """A view in a few words: damage and its sizes, speed, load."""
    shown = view.shown()
    names = [name for name, of in SLIDERS.items() if of.kinds and name != "place" and view.applies(name)]
    words = [KINDS[view.kind], *(f"{shown[name]} {SLIDERS[name].unit}".rstrip() for name in names)]
    return f"{' '.join(words)}, {shown['speed']} km/h, {shown['load']} t"


def readouts(answer: Answer) -> dict[str, str]:
    """Text of each readout of the page, in the units of the railway."""
    forces, worst = answer.block.forces / 1e3, int(answer.amplitude.argmax())
    loss, amplitude = 1e3 * answer.contact_loss[answer.wheel], answer.amplitude / 1e6
    static = answer.undamaged / 1e6
    return {
        **{f"{name}-peak": f"{forces[:, wheel].max():.0f} kN" for wheel, name in enumerate(WHEELS)},
        "loss": f"{loss:.1f} ms" if loss else "none",
        "amplitude": f"{amplitude[worst]:.1f} MPa",
        "amplitude-note": f"at {answer.nodes[worst]}; {static[worst]:.1f} without damage",
    }


def moment_message(number: int, row: int, answer: Answer, moment: Moment) -> bytes:
    """Pressure and bodies at a sample, in MPa and mm, with the values of the curves there in words."""
    patch = moment.patch
    x, rail, wheel = (1e3 * each for each in moment.profiles())
    touched = np.isin(np.round(x, 4), np.round(1e3 * patch.x[patch.pressure.max(axis=1) > 0], 4))
    nowhere = np.full(len(x), np.nan)
    arrays = {"x": x, "rail": rail, "wheel": wheel, "touched": np.where(touched, rail, nowhere)}
    part_x, part_y = (_shown(patch.pressure.max(axis=axis) > 0) for axis in (1, 0))
    pressure = patch.pressure[part_x, part_y].T / 1e6
    arrays["image"] = np.where(pressure > 0, pressure, np.nan)
    dx, dy = (1e3 * float(axis[1] - axis[0]) for axis in (patch.x, patch.y))
    at_x, at_y = 1e3 * patch.x[part_x], 1e3 * patch.y[part_y]
    middle = 1e3 * float(np.mean(patch.y))
    force, largest = patch.force / 1e3, float(pressure.max(initial=0.0))
    words = f"wheel {answer.wheel + 1} at {answer.position[row]:.3f} m: "
    if patch.force > 0:
        long, wide = ((patch.pressure.max(axis=axis) > 0).sum() * step for axis, step in ((1, dx), (0, dy)))
        words += f"{force:.1f} kN, up to {largest / 1e3:.2f} GPa, contact {long:.0f} mm long and {wide:.0f} mm wide"
        words += f". {patch.flag[0].upper()}{patch.flag[1:]}" if patch.flag else ""
    else:
        words += f"no contact, {1e3 * moment.gap:.3f} mm apart"
    header = {
        "kind": "moment",
        "number": number,
        "row": row,
        "words": words,
        "largest": max(largest, 1.0),
        "image": [len(at_x), len(at_y), at_x[0] - dx / 2, at_y[0] - dy / 2, dx, dy],
        "reach": [max(CLOSEST, float(np.abs(at).max())) for at in (at_x, at_y - middle)],
        "middle": middle,
    }
    return packed(header, arrays)


def _shown(touched: Any) -> slice:
    """The elements in contact with some around them; those at the middle without contact."""
    rows = np.flatnonzero(touched)
    first, last = (rows[0], rows[-1]) if len(rows) else (len(touched) // 2, len(touched) // 2)
    return slice(max(0, int(first) - MARGIN), int(last) + MARGIN + 1)
