"""``info``: list the contents of a bag."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.table import Table

from ..bags.losses import Gap
from ..bags.overview import Overview, overview
from ..errors import printable
from ..scenario import WHEELS
from .console import print_object, terminal
from .contacts import contact, contact_words

WIDEST = 44
"""Characters of a name in one line: more than half of a terminal of 80."""
LONGEST = 60
"""Characters of a value that a table shows."""


def info(bag: Path, *, json: bool) -> int:
    """Print the contents of a bag; returns the exit status."""
    found = overview(bag)
    console = terminal()
    if json:
        print_object(as_mapping(found))
        return 0
    for table in tables(found):
        console.print(table)
    for loss in found.losses:
        console.print(f"lost: {loss}", highlight=False, soft_wrap=True)
    for what in found.unchecked:
        console.print(f"not checked: {what}", highlight=False, soft_wrap=True)
    return 0


def as_mapping(found: Overview) -> dict[str, Any]:
    """The object that ``info --json`` prints; null for values that the bag lacks."""
    summary = found.summary
    return {
        "bag": str(found.path),
        "complete": found.complete,
        "scenario": found.info.scenario_name,
        "digest": found.info.digest,
        "models": dict(found.info.models),
        "versions": dict(found.info.versions),
        "start_ns": found.start_ns,
        "first_step": found.first_step,
        "steps": found.steps,
        "start_s": found.start,
        "duration_s": found.duration,
        "files": [{"name": name, "bytes": size} for name, size in found.files.items()],
        "topics": {topic: of._asdict() for topic, of in found.topics.items()},
        "wheels": {
            name: {
                "max_force_N": _number(wheel.max_force),
                "min_force_N": _number(wheel.min_force),
                "contact_loss_s": _number(wheel.contact_loss),
                "impacts": impacts,
            }
            for name, wheel, impacts in zip(WHEELS, summary.wheels, found.impacts, strict=True)
        }
        if summary
        else {},
        "nodes": {
            node.name: {
                "max_principal_Pa": _number(node.max_principal),
                "min_principal_Pa": _number(node.min_principal),
            }
            for node in summary.nodes
        }
        if summary
        else {},
        "contact": contact(summary) if summary else {},
        "revisions": [
            {
                "revision": revision.number,
                "step": revision.step,
                "changed": {change.key: [change.before, change.after] for change in revision.changed},
            }
            for revision in found.revisions
        ],
        "gaps": [asdict(gap) for gap in found.gaps],
        "not_checked": [*found.unchecked],
        "damage": [asdict(loss) for loss in found.losses if not isinstance(loss, Gap)],
    }


def tables(found: Overview) -> list[Table]:
    """The same for people: the run, its revisions, its topics."""
    run = Table("", "", title=printable(f"{found.path.absolute().name}: {found.info.scenario_name}"), show_header=False)
    last = found.first_step + found.steps + sum(gap.steps for gap in found.gaps) - 1
    run.add_row("simulated time", f"{found.duration:.6g} s from {found.start:.6g} s on")
    run.add_row("steps", f"{found.steps}, from {found.first_step} to {last}" if found.steps else "none")
    run.add_row("gaps", f"{len(found.gaps)}, {sum(gap.steps for gap in found.gaps)} steps" if found.gaps else "none")
    run.add_row("files", f"{len(found.files)}, {sum(found.files.values()) / 1e6:.3g} MB")
    run.add_row("complete", "yes" if found.complete else "no")
    if found.summary:
        for name, wheel, impacts in zip(WHEELS, found.summary.wheels, found.impacts, strict=True):
            force = f"{wheel.min_force / 1e3:.1f} to {wheel.max_force / 1e3:.1f} kN"
            run.add_row(f"contact force {name}", f"{force}, {wheel.contact_loss * 1e3:.2f} ms lost, {impacts} impacts")
        for node in found.summary.nodes:
            stress = f"{node.min_principal / 1e6:.1f} to {node.max_principal / 1e6:.1f} MPa"
            run.add_row(f"maximum principal stress {node.name}", stress)
        if words := contact_words(contact(found.summary)):
            run.add_row("contacts without a force table", words)
    run.add_row("digest", found.info.digest)
    for software, version in found.info.versions.items():
        run.add_row(f"version of {software}", version)

    changes = Table("revision", "step", title="revisions")
    keys = [change.key for revision in found.revisions for change in revision.changed]
    changes.add_column("key", no_wrap=_in_one_line(keys), overflow="fold")
    changes.add_column("before", overflow="fold")
    changes.add_column("after", overflow="fold")
    for revision in found.revisions:
        where = [str(revision.number), str(revision.step)]
        for key, *values in revision.changed or [("", None, None)]:
            changes.add_row(*where, key, *(_short(value) for value in values))
            where = ["", ""]

    topics = Table(title="topics")
    topics.add_column("topic", no_wrap=_in_one_line(found.topics), overflow="fold")
    topics.add_column("type", overflow="fold")
    topics.add_column("messages", justify="right")
    for topic, of in found.topics.items():
        topics.add_row(topic, of.type.replace("/msg/", "/"), str(of.messages))
    return [run, *([changes] if len(found.revisions) > 1 else []), topics]


def _in_one_line(names: Iterable[str]) -> bool:
    """Whether a column shows names in one line each; longer ones would leave no room and are folded, not cut."""
    return max(map(len, names), default=0) <= WIDEST


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _short(value: Any) -> str:
    text = "" if value is None else f"{value}"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
