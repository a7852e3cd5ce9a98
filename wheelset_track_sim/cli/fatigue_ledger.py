"""``fatigue`` of several runs, and of ledgers: what an axle went through in all."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..bags.bag import Bag
from ..errors import InputError, warn
from ..fatigue.curve import load_curve
from ..fatigue.ledger import (
    KNOWN,
    SUFFIX,
    Basis,
    Ledger,
    LedgerEntry,
    changed_ledger,
    load_ledger,
    run_identity,
)
from ..fatigue.rainflow import GATE
from ..scenario import load_scenario
from .booking import Booking
from .console import print_object, terminal
from .fatigue import as_mapping, counted, is_bag, table

AXLE = "axle"
"""Name of an axle that has none."""
SHORTEST = 1.0
"""From checkpoint to checkpoint, m."""


def is_ledger(run: str) -> bool:
    """Whether a name is one of a ledger."""
    return Path(run).suffix == SUFFIX


@dataclass(frozen=True)
class Keep:
    """How runs go into a ledger."""

    ledger: Path
    axle: str
    run: str | None = None
    """Name of the run; None for its identity."""
    checkpoint: float = 5000.0
    """Distance from checkpoint to checkpoint, m."""

    def __post_init__(self) -> None:
        if not self.checkpoint >= SHORTEST:
            raise InputError(f"--checkpoint {self.checkpoint:g} m is out of range: give at least {SHORTEST:g} m")


def identity_of(run: str, changes: Sequence[str]) -> str:
    """Identity of a scenario's run, or of that in a bag, which is the same if it was recorded without a clock."""
    if not is_bag(run):
        return run_identity(load_scenario(run, changes).to_yaml(), 0)
    bag = Bag(Path(run))
    begin = bag.info.inputs[0].scenario if bag.info.inputs else bag.info.scenario
    return run_identity(begin, bag.start_ns)


def fatigue_of_several(
    runs: Sequence[str],
    changes: Sequence[str],
    curve_name: str,
    distance: float | None,
    *,
    angles: int,
    gate: float | None,
    json: bool,
    warnings: Sequence[str] = (),
    mark: float = 0.0,
    keep: Keep | None = None,
) -> int:
    """Count runs, take in ledgers, and print each run and what they add up to; returns the exit status.

    With ``keep`` all of them go into a ledger, which goes on from where it was after a crash.
    """
    if keep is not None and keep.run is not None and len(runs) > 1:
        raise InputError("--run names one run: give one SCENARIO or BAG with it")
    merged = [load_ledger(Path(run)) for run in runs if is_ledger(run)]
    basis = Basis(load_curve(curve_name), angles, GATE if gate is None else gate)
    if len(merged) == len(runs):
        basis = merged[0].basis
    ledger = Ledger(basis)
    if merged:
        with _open(keep, ledger) as ledger:
            for each in merged:
                ledger.merge(each)
    results = []
    for run in (each for each in runs if not is_ledger(each)):
        who = keep.run if keep is not None and keep.run is not None else identity_of(run, changes)
        booking = None if keep is None else Booking(keep.ledger, keep.axle, who, keep.checkpoint)
        how: Any = {"angles": angles, "gate": gate, "mark": mark, "booking": booking}
        found, name = counted(run, changes, basis.curve, distance, **how)
        entry = LedgerEntry.of(found, keep.axle if keep else AXLE, who, name, finished=True)
        with _open(keep, ledger) as ledger:
            if ledger.put(entry) == KNOWN:
                warn(f"{run}: these steps are in the ledger, and are not added again: give --run NAME if it ran again")
        results.append(as_mapping(name, found.nodes, found.spectrum, basis.curve))
        if not json:
            terminal().print(table(name, found.nodes, basis.curve))
    whole = ledger_mapping(ledger, str(keep.ledger) if keep else "") | {"warnings": [*warnings]}
    print_object({"runs": results, **whole}) if json else _print(ledger)
    return 0


def _open(keep: Keep | None, ledger: Ledger) -> AbstractContextManager[Ledger]:
    """The ledger to change: that of the file, or the one in memory."""
    return nullcontext(ledger) if keep is None else changed_ledger(keep.ledger, ledger.basis)


def _print(ledger: Ledger) -> None:
    for axle in ledger.axles:
        entries = [each for each in ledger.entries if each.axle == axle]
        plural = "s" if len(entries) > 1 else ""
        terminal().print(table(f"{axle}, {len(entries)} run{plural}", ledger.total(axle), ledger.basis.curve))
        for each in entries:
            steps = (
                f"steps {each.first_step} to {each.end - 1}, {each.distance:.0f} m{', not finished' * bool(each.state)}"
            )
            terminal().print(f"run {each.run}: {each.name}, {steps}", highlight=False, soft_wrap=True)


def ledger_mapping(ledger: Ledger, file: str) -> dict[str, Any]:
    """The object that ``fatigue --json`` prints of a ledger."""
    rules = ledger.basis.curve.rules
    return {
        "ledger": file,
        "curve": dataclasses.asdict(ledger.basis.curve) | {"assumed": ledger.basis.curve.assumed},
        "angles": ledger.basis.points,
        "axles": {
            axle: {
                "runs": [
                    {
                        "run": each.run,
                        "scenario": each.name,
                        "first_step": each.first_step,
                        "steps": each.steps,
                        "distance_m": each.distance,
                        "finished": not each.state,
                    }
                    for each in ledger.entries
                    if each.axle == axle
                ],
                "nodes": {
                    node.name: {
                        "distance_m": node.distance,
                        "ratio_to_undamaged": dict(
                            zip(rules, (None if math.isnan(each) else each for each in node.ratios), strict=True)
                        ),
                        "rotating_amplitude_Pa": node.amplitude,
                        "worst_angle_rad": node.angle,
                        "damage": dict(zip(rules, node.damage[node.worst].tolist(), strict=True)),
                        "undamaged_damage": dict(zip(rules, node.undamaged.tolist(), strict=True)),
                        "damage_by_angle": node.damage[:, 0].tolist(),
                    }
                    for node in ledger.total(axle)
                },
            }
            for axle in ledger.axles
        },
    }
