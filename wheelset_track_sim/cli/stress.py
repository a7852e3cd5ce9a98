"""``stress``: axle stresses from a file of contact forces, measured or not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from ..bags import BagWriter, RunInfo
from ..bags.bag_writer import SECOND_NS
from ..dynamics.stress_from_forces import stresses_from_forces
from ..errors import InputError
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real
from ..runtime.cache import digest
from ..samples.block import SampleBlock
from ..scenario.loads import Loads
from ..simulation.superposition import superposition
from ..twin.measured import Reading, read_measurement
from ..twin.measured.csv_file import write_csv
from ..twin.measured.measurement import WHEELS, evenly
from ..wheelset.kinds import load_wheelset, reduce_wheelset
from ..wheelset.reduced import COMPONENTS
from .console import print_object, terminal
from .progress import shown

CHUNK = 1000
"""Samples of a message in a bag."""
LATEST = 2.0**31
"""Times from here on do not fit into a time stamp of ROS, s."""


@dataclass(frozen=True)
class Running:
    """How the wheelset ran; it turns positions into times."""

    speed: float = quantity("m/s", 0.1, 150.0, "the speed")

    def __post_init__(self) -> None:
        check(self)


def stress(
    forces: Path,
    wheelset: str,
    nodes: Sequence[str] | None,
    speed: float | None,
    out: Path | None,
    reading: Reading | None = None,
    *,
    own_weight: bool = False,
    json: bool,
    warnings: Sequence[str] = (),
) -> int:
    """Work out the stresses, write and print them; returns the exit status."""
    described, loads = load_wheelset(wheelset), Loads(own_weight=own_weight)
    loads.check_against(described)
    block = _block(forces, speed, reading)
    with shown() as progress:
        reduced = reduce_wheelset(described, progress)
    found = stresses_from_forces(reduced, block.forces, block.step_period, nodes)
    names = reduced.node_names if nodes is None else tuple(nodes)
    added = superposition(loads, described, reduced, names)
    if added is not None:
        found += added.stresses(np.zeros(1)).reshape(len(names), len(COMPONENTS))
    block = _with(block, found, names)
    if out is not None:
        _write(out, block, forces, speed, RunInfo(f"stress of {forces.name}", "", digest(described), float("nan")))
    result = {
        "forces": str(forces),
        "wheelset": described.name,
        "samples": len(block),
        "step_s": block.step_period,
        "nodes": {
            name: {"max_principal_Pa": float(largest.max()), "min_principal_Pa": float(largest.min())}
            for name, largest in zip(names, block.max_principal.T, strict=True)
        },
    }
    if out is not None:
        result["out"] = str(out)
    console = terminal()
    if json:
        print_object(result | {"warnings": [*warnings]})
    else:
        console.print(_table(result))
    return 0


def _block(path: Path, speed: float | None, reading: Reading | None) -> SampleBlock:
    """Forces of a file at even distances in time, as a block without stresses."""
    found = read_measurement(path, reading)
    missing = [wheel for wheel in WHEELS if wheel not in found.signals]
    if missing:
        raise InputError(
            f"{path} has no {' and no '.join(missing)}: give the forces of both wheels, as the stress depends on both"
        )
    if speed is not None:
        Running(speed)
    if found.axis == "position" and speed is None:
        raise InputError(f"{path} holds forces over position: give --speed, at which the wheelset ran")
    even = evenly(found)
    start = float(found.origin) + even.start
    per_second = speed if found.axis == "position" and speed is not None else 1.0
    columns = [[*found.signals].index(wheel) for wheel in WHEELS]
    return SampleBlock(
        first_step=0,
        time=start / per_second,
        step_period=even.step / per_second,
        speed=speed if speed is not None else float("nan"),
        position=start if found.axis == "position" else start * (speed or float("nan")),
        revision=0,
        forces=np.ascontiguousarray(even.signals[:, columns]),
        stresses=np.zeros((len(even.signals), 0, len(COMPONENTS))),
        nodes=(),
    )


def _with(block: SampleBlock, stresses: Real, nodes: tuple[str, ...], part: slice = slice(None)) -> SampleBlock:
    first = part.start or 0
    return SampleBlock(
        first_step=first,
        time=block.time + first * block.step_period,
        step_period=block.step_period,
        speed=block.speed,
        position=block.position + first * block.step_period * block.speed,
        revision=0,
        forces=block.forces[part],
        stresses=stresses[part],
        nodes=nodes,
    )


def _write(out: Path, block: SampleBlock, source: Path, speed: float | None, info: RunInfo) -> None:
    if out.suffix == ".csv":
        time = np.arange(len(block), dtype=np.float64) * block.step_period + block.time
        signals = {name: block.max_principal[:, index] for index, name in enumerate(block.nodes)}
        signals |= {
            f"{name}_{component}": block.stresses[:, node, index]
            for node, name in enumerate(block.nodes)
            for index, component in enumerate(COMPONENTS)
            if block.stresses[:, node, index].any()
        }
        write_csv(out, "time", time, signals, "Pa")
        return
    if out.suffix != ".mcap":
        raise InputError(f"--out {out} ends neither in .csv nor in .mcap: give a name that does")
    if speed is None:
        raise InputError(f"a bag holds the position of each sample: give --speed, at which {source} was measured")
    with BagWriter(out, info, start_ns=_start_ns(block)) as bag:
        for first in range(0, len(block), CHUNK):
            bag.write(_with(block, block.stresses, block.nodes, slice(first, min(first + CHUNK, len(block)))))


def _start_ns(block: SampleBlock) -> int:
    """Time stamp of time 0, ns: 0 if all samples can have stamps then, otherwise such that the first one is near 0."""
    fits = block.time >= 0.0 and block.time + len(block) * block.step_period < LATEST
    return 0 if fits else -math.floor(block.time) * SECOND_NS


def _table(result: dict[str, Any]) -> Table:
    """The same for people: MPa."""
    duration = result["samples"] * result["step_s"]
    title = f"stress of {result['wheelset']} under {Path(result['forces']).name}: {duration:.4g} s"
    shown_as = Table(title=title, title_justify="left")
    for heading in ("", "maximum", "minimum"):
        shown_as.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    for name, node in result["nodes"].items():
        high, low = node["max_principal_Pa"] / 1e6, node["min_principal_Pa"] / 1e6
        shown_as.add_row(f"maximum principal stress {name}", f"{high:.1f} MPa", f"{low:.1f} MPa")
    return shown_as
