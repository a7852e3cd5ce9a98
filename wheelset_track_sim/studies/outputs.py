"""Numbers that a study keeps of each run, by name: ``wheels.wheel_1.max_force``, ``nodes.A1.max_principal``.

What a detector beside the track reads is ``wayside.shear_array.wheel_1_peak_read``, with the name of its topic.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ..errors import InputError
from ..fatigue.axle import NodeFatigue
from ..inputs.schema import unknown
from ..samples.summary import Summary
from ..scenario import WHEELS
from ..wayside.watch import WaysidePassage

OF_WHEELS = {
    "max_force": ("contact force", "max", "N"),
    "min_force": ("contact force", "min", "N"),
    "mean_force": ("contact force", "mean", "N"),
    "rms_force": ("contact force", "root mean square", "N"),
    "contact_loss": ("time without contact", "", "s"),
}
OF_NODES = {
    "max_principal": ("max. principal stress", "max", "Pa"),
    "min_principal": ("max. principal stress", "min", "Pa"),
}
OF_FATIGUE = {
    "rotating_amplitude": ("rotating amplitude", "", "Pa"),
    "damage_ratio": ("* damage ratio to undamaged", "", ""),
}
"""Quantity, what of it over time, SI unit. A star marks what depends on an S-N curve."""
STARRED = "damage_ratio"
OF_WAYSIDE = {
    f"{wheel}_{name}": (f"{what}, {wheel.replace('_', ' ')},", of, unit)
    for wheel in WHEELS
    for name, what, of, unit in (
        ("mean_read", "force read", "mean", "N"),
        ("peak_read", "force read", "max", "N"),
        ("dynamic_factor_read", "dynamic factor read", "", ""),
        ("peak_force", "contact force while it is read", "max", "N"),
    )
}
FORCES = tuple(f"wheels.{wheel}.max_force" for wheel in WHEELS)
"""Largest contact forces, which limits are for."""


SMALLEST, LARGEST = " smallest", " largest"
"""Behind the name of an output: over places of the bay."""


def known_outputs(nodes: Sequence[str], detectors: Sequence[str] = ()) -> list[str]:
    """Names of all outputs of a run with these stress nodes, and these detectors beside the track."""
    wayside = [f"wayside.{detector}.{name}" for detector in detectors for name in OF_WAYSIDE]
    wheels = [f"wheels.{wheel}.{name}" for wheel in WHEELS for name in OF_WHEELS]
    return [*wheels, *(f"nodes.{node}.{name}" for node in nodes for name in OF_NODES | OF_FATIGUE), *wayside]


def nodes_of_fatigue(names: Iterable[str]) -> tuple[str, ...]:
    """Stress nodes of which outputs of fatigue are among the names, each once."""
    parts = [name.removeprefix("nodes.").rpartition(".") for name in names if name.startswith("nodes.")]
    return tuple(dict.fromkeys(node for node, _, quantity in parts if quantity in OF_FATIGUE))


def check_output(name: str, nodes: Sequence[str], where: str, detectors: Sequence[str] = ()) -> None:
    """Raise InputError for an output that a run with these stress nodes and detectors does not have."""
    known = known_outputs(nodes, detectors)
    if name not in known:
        raise InputError(unknown("output", f"{where} = {name!r}", name, known))


def value_of(summary: Summary, name: str) -> float:
    """Output of a run's summary, SI; NaN for what is not in it."""
    kind, of, quantity = name.split(".")
    if kind == "wheels":
        return float(getattr(summary.wheels[WHEELS.index(of)], quantity))
    return next((float(getattr(node, quantity, math.nan)) for node in summary.nodes if node.name == of), math.nan)


def values_of_fatigue(nodes: Iterable[NodeFatigue]) -> dict[str, float]:
    """All outputs of fatigue of stress nodes, SI."""
    return {
        f"nodes.{node.name}.{quantity}": value
        for node in nodes
        for quantity, value in zip(OF_FATIGUE, (node.amplitude, node.ratios[0]), strict=True)
    }


def wayside_values(passage: WaysidePassage) -> dict[str, float]:
    """Outputs of a passage of a detector, by name."""
    found: dict[str, float] = {}
    for wheel, verdict in zip(WHEELS, passage.verdicts, strict=True):
        read = verdict.read
        numbers = (read.mean, read.peak, read.dynamic_factor, verdict.true.peak)
        names = [name for name in OF_WAYSIDE if name.startswith(wheel)]
        found |= {f"{passage.topic.replace('/', '.')}.{name}": each for name, each in zip(names, numbers, strict=True)}
    return found


def unit_of(name: str) -> str:
    """SI unit of an output."""
    return _of(name)[2]


def quantity_of(name: str) -> str:
    """What an output is, without wheel or node."""
    return _of(name)[0]


def extreme_of(name: str) -> str:
    """What of its quantity over time an output is: ``max``."""
    return _of(name)[1]


def place_of(name: str) -> str:
    """Wheel or node of an output."""
    return name.split(".")[1].replace("_", " ")


def label_of(name: str) -> str:
    """An output as people read it."""
    return ", ".join(filter(None, (f"{quantity_of(name)} {place_of(name)}", extreme_of(name))))


def _of(name: str) -> tuple[str, str, str]:
    return (OF_WHEELS | OF_NODES | OF_FATIGUE | OF_WAYSIDE)[name.rpartition(".")[2]]
