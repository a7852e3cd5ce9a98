"""``resimulate``: a recorded run simulated again, as it was or with other settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.table import Table

from ..scenario import WHEELS
from ..twin import Resimulation, resimulate
from ..twin.differences import Difference, SamplePlace
from ..twin.resimulation import MOST_STEPS
from .console import print_object, terminal
from .progress import shown
from .run import peaks


def run_resimulate(
    bag: Path, settings: Sequence[str], out: Path | None, most_steps: int | None = None, *, json: bool
) -> int:
    """Simulate the run of a bag again and print how it compares; returns the exit status.

    It is 1 if the same software on the same processor gives other numbers with the same settings.
    """
    with shown() as progress:
        found = resimulate(bag, settings, out, progress, MOST_STEPS if most_steps is None else most_steps)
    if json:
        print_object(as_mapping(found))
    else:
        console = terminal()
        console.print(table(found))
        for line in verdict(found):
            console.print(line, highlight=False, soft_wrap=True)
    return 1 if found.unexplained else 0


def as_mapping(found: Resimulation) -> dict[str, Any]:
    """The object that ``resimulate --json`` prints."""
    start = found.inputs.start
    return {
        "bag": str(found.path),
        "identical": found.identical,
        "samples": found.samples,
        "compared_nodes": [*found.nodes],
        "not_compared": [*found.left_out],
        "duration_s": found.duration,
        "revisions": len(found.inputs.changes) - 1,
        "unknown_revisions": [*found.unknown],
        "lost": [*map(str, found.lost)],
        "set": [*found.settings],
        "from_step": start.step if start else 0,
        "beginning_known": start is None,
        "force": _difference(found.force, "N"),
        "stress": _difference(found.stress, "Pa"),
        "sensors": {topic: difference and asdict(difference) for topic, difference in found.sensors.items()},
        "moved_revisions": [
            {"revision": revision, "recorded_step": recorded, "step": step} for revision, recorded, step in found.moved
        ],
        "digests_comparable": not found.digests_differ,
        "differs_here": {name: {"bag": bag, "here": here} for name, (bag, here) in found.origin.items()},
        "recorded": peaks(found.before),
        "simulated": peaks(found.after),
    }


def _difference(of: Difference | None, unit: str) -> dict[str, Any] | None:
    if of is None:
        return None
    return {
        f"largest_{unit}": of.largest,
        "signal": of.signal,
        "at": _place(of.at),
        "first": _place(of.first),
        "last_beyond_0.1_percent": _place(of.last_beyond) if of.last_beyond else None,
    }


def _place(of: SamplePlace) -> dict[str, Any]:
    return {"step": of.step, "time_s": of.time, "position_m": of.position}


def table(found: Resimulation) -> Table:
    """Peaks as recorded and as simulated again, for people: kN, MPa, ms."""
    changes = len(found.inputs.changes) - 1
    title = f"{found.path.absolute().name}: {found.duration:.4g} s, {found.samples} steps, {changes} changes"
    if found.settings:
        title += f"\nwith {', '.join(found.settings)}"
    shown_as = Table(title=title, title_justify="left")
    for heading in ("", "recorded", "as set" if found.settings else "simulated again", "difference"):
        shown_as.add_column(heading, justify="right" if heading else "left", no_wrap=True)

    def row(label: str, before: float, after: float, unit: str, digits: int = 1) -> None:
        shown_as.add_row(label, *(f"{value:.{digits}f} {unit}" for value in (before, after, after - before + 0.0)))

    for name, old, new in zip(WHEELS, found.before.wheels, found.after.wheels, strict=True):
        row(f"contact force {name}, max", old.max_force / 1e3, new.max_force / 1e3, "kN")
        row(f"contact force {name}, min", old.min_force / 1e3, new.min_force / 1e3, "kN")
        row(f"contact loss {name}", 1e3 * old.contact_loss, 1e3 * new.contact_loss, "ms", 2)
    after = {node.name: node for node in found.after.nodes}
    for node in found.before.nodes:
        if node.name in after:
            new_node = after[node.name]
            label = f"max. principal stress {node.name}"
            row(f"{label}, max", node.max_principal / 1e6, new_node.max_principal / 1e6, "MPa")
            row(f"{label}, min", node.min_principal / 1e6, new_node.min_principal / 1e6, "MPa")
    return shown_as


def verdict(found: Resimulation) -> list[str]:
    """The result in lines of text."""
    lines = []
    start = found.inputs.start
    if start:
        lines.append(
            f"The bag has no inputs from before step {start.step} ({start.time:.4f} s): the simulation starts there in "
            "steady running, unlike the recorded run."
        )
    if found.unknown:
        lines.append(f"The bag does not contain the change of revision {', '.join(map(str, found.unknown))}.")
    lines += [f"Not compared: {what}." for what in (*found.left_out, *found.lost)]
    if found.identical:
        stresses = f"all stresses of {', '.join(found.nodes)}" if found.nodes else "no stresses"
        sensors = f", {len(found.sensors)} sensors" if found.sensors else ""
        lines.append(
            f"Bit-identical: both contact forces{sensors} and {stresses} are the same to the last bit in the "
            f"{found.samples} steps that were compared ({found.duration:.4g} s)."
        )
    for name, difference, scale, unit in (("force", found.force, 1e3, "kN"), ("stress", found.stress, 1e6, "MPa")):
        if difference is not None:
            at, first = difference.at, difference.first
            lines.append(
                f"Largest difference in {name}: {difference.largest / scale:.3g} {unit} ({difference.signal}) at step "
                f"{at.step}, {at.time:.4f} s, {at.position:.3f} m; the first at step {first.step}, {first.time:.4f} s, "
                f"{first.position:.3f} m."
            )
            if start:
                settled = difference.last_beyond
                since = f"from {settled.time:.3f} s on" if settled else "all along"
                lines.append(f"Within 0.1 % of the static value {since}.")
    lines += [
        f"Largest difference in {topic} {difference.channel}: {difference.largest:.3g} (SI) at {difference.time:.4f} s."
        for topic, difference in found.sensors.items()
        if difference is not None
    ]
    for revision, recorded, step in found.moved[:5]:
        lines.append(
            f"Revision {revision} takes effect at step {step}, not {recorded}: a defect that changes is in the "
            "contact patch there."
        )
    for name, (bag, here) in found.origin.items():
        lines.append(f"{name} differs: {here} here, {bag} in the bag.")
    if found.origin and found.identical:
        lines.append("These differences do not affect the numbers that were compared: they agree bit for bit.")
    if found.digests_differ:
        equal = ", which the equal numbers show to be the same" if found.identical and not found.settings else ""
        lines.append(
            f"Recorded by version {found.digests_differ}, whose digests have another form: they do not show whether "
            f"wheelset and track are the same as in the bag{equal}."
        )
    return lines
