"""``map``: a study of two keys of a scenario, made from one line, with one picture."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..inputs import amounts
from ..inputs.schema import read, unknown
from ..runtime.output_files import file_name
from ..scenario import load_scenario
from ..scenario.meaning import meaning_of
from ..studies.conduct import Resources
from ..studies.distributions import PARAMETERS
from ..studies.outputs import known_outputs, label_of
from ..studies.study import Study
from .study import RESULTS, carry_out, require_forms, task_of

MOST_POINTS = 200
"""Along an axis."""
_RANGE = re.compile(r"\s*(.+?)\s*\.\.\s*(.+?)\s*")
_DRAWN = re.compile(r"\s*([a-z_]+)\s*\((.*)\)\s*")
_UNIT = re.compile(r"\s*[-+\d.eE]+\s*(.*?)\s*")


def map_(
    scenario: str,
    axes: Sequence[str],
    points: str,
    quantity: str,
    limits: Sequence[str],
    sampling: Mapping[str, Any],
    changes: Sequence[str],
    out: Path | None,
    resources: Resources,
    forms: Collection[str],
) -> int:
    """Run the study, draw the map and print what came out; returns the exit status.

    Raises InputError before anything runs for whatever cannot be used.
    """
    require_forms(forms)
    study = study_of(scenario, axes, points, quantity, limits, sampling)
    names = [Path(scenario).stem, *study.vary]
    folder = out or RESULTS / file_name("-".join(["map", *names, *(change for change in changes)]))
    return carry_out([task_of(folder.name, study, changes, folder)], resources, forms)


def study_of(
    scenario: str,
    axes: Sequence[str],
    points: str,
    quantity: str,
    limits: Sequence[str],
    sampling: Mapping[str, Any],
) -> Study:
    """The study that arguments of the command mean; raises InputError."""
    base = load_scenario(scenario)
    output = _output(quantity, base.output.stress_nodes)
    counts = _counts(points)
    vary = dict(axis_of(text, count, f"--{name}") for text, count, name in zip(axes, counts, "xy", strict=True))
    if len(vary) < 2:
        raise InputError(f"--y {axes[1]} varies what --x does: give another key")
    x, y = vary
    of = f"{label_of(output)}, over {meaning_of(x)[0]} and {meaning_of(y)[0]}"
    drawings: list[dict[str, Any]] = [
        {"type": "map", "name": "map", "title": f"{base.name}: {of}", "x": x, "y": y, "output": output}
        | {"limits": list(limits)}
    ]
    if sampling.get("method") == "saltelli":
        title = f"{base.name}: what {label_of(output)} depends on"
        drawings.append({"type": "sensitivities", "name": "sensitivities", "title": title, "outputs": [output]})
    given: dict[str, Any] = {
        "title": f"{base.name}: {of}",
        "scenario": base.to_mapping(),
        "vary": vary,
        "outputs": [output],
        "drawings": drawings,
    }
    if sampling:
        given["sampling"] = dict(sampling)
    return read(Study, given, "")


def axis_of(text: str, count: int, where: str) -> tuple[str, Any]:
    """Key and axis, as in a study's ``vary``, of ``KEY=LOW..HIGH`` with ``count`` points, or ``KEY=normal(...)``.

    Raises InputError, which begins with ``where``.
    """
    key, equals, given = text.partition("=")
    key, span, drawn = key.strip(), _RANGE.fullmatch(given), _DRAWN.fullmatch(given)
    if not equals or not (span or drawn):
        raise InputError(
            f"{where} {text} is not an axis: give KEY=LOW..HIGH, such as speed=40..200km/h, or KEY=normal(MEAN, "
            "DEVIATION), uniform or lognormal"
        )
    si = meaning_of(key)[1]
    if drawn:
        kind, arguments = drawn[1], [each.strip() for each in drawn[2].split(",")]
        if kind not in PARAMETERS:
            raise InputError(unknown("distribution", f"{where} {text}", kind, [*PARAMETERS]))
        names = PARAMETERS[kind]
        if len(arguments) != len(names):
            raise InputError(f"{where} {text} has {len(arguments)} parameters: give {kind}({', '.join(names)})")
        return key, {"distribution": kind} | dict(zip(names, _with_units(arguments), strict=True))
    assert span is not None
    low, high = (amounts.amount(each, si, f"{where} {key}") for each in _with_units([span[1], span[2]]))
    if not low < high:
        raise InputError(f"{where} {text} has no range: give the lower end first, then a higher one")
    # Twelve digits: a third of a range is no better known.
    return key, {"values": [float(f"{value:.12g}") for value in np.linspace(low, high, count)]}


def _with_units(texts: Sequence[str]) -> list[str]:
    """Amounts, those without a unit in the unit of the last one: ``40..200km/h``."""
    found = _UNIT.fullmatch(texts[-1])
    unit = found[1] if found else ""
    alone = [_UNIT.fullmatch(text) for text in texts]
    return [f"{text} {unit}".strip() if bare and not bare[1] else text for text, bare in zip(texts, alone, strict=True)]


def _output(quantity: str, nodes: Sequence[str]) -> str:
    """Output of a name or of its end; of several, the first."""
    known = known_outputs(nodes)
    found = [name for name in known if name == quantity or name.endswith(f".{quantity}")]
    if not found:
        raise InputError(unknown("output", f"--quantity {quantity}", quantity, known))
    return found[0]


def _counts(points: str) -> tuple[int, int]:
    parts = points.lower().split("x")
    counts = [int(part) for part in parts if part.isdecimal() and len(part) < 6]
    if len(counts) != len(parts) or len(counts) > 2 or not all(2 <= count <= MOST_POINTS for count in counts):
        raise InputError(f"--points {points} is out of range: give 2 to {MOST_POINTS}, such as 13, or 17x13")
    return counts[0], counts[-1]
