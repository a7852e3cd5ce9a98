"""``recover``: write a bag that all tools open from a damaged one."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from ..bags.recover import Recovered, recover
from .console import terminal


def run_recover(bag: Path, out: Path | None) -> int:
    """Recover a bag and print how much was saved and lost; returns the exit status."""
    found = recover(bag, out)
    console = terminal()
    console.print(table(found))
    for loss in found.losses:
        console.print(f"lost: {loss}", highlight=False, soft_wrap=True)
    console.print(f"bag   {found.path}", highlight=False, soft_wrap=True)
    return 0


def table(found: Recovered) -> Table:
    """Amounts that were saved, and that are known to be lost."""
    shown = Table("", "saved", "lost", title=f"recovered {found.path.name}")
    for column in shown.columns[1:]:
        column.justify = "right"
    lost_steps = sum(gap.steps for gap in found.gaps)
    lost_seconds = sum(gap.seconds for gap in found.gaps)
    shown.add_row("chunks of the file", str(found.chunks), str(found.chunks_lost))
    shown.add_row("messages", str(found.messages), "")
    shown.add_row("steps", str(found.steps), f"{lost_steps} in between")
    shown.add_row("simulated time", f"{found.seconds:.4g} s", f"{lost_seconds:.4g} s in between")
    shown.add_row("first step", str(found.first_step), "")
    shown.add_row("bytes that cannot be read", "", str(found.bytes_lost))
    return shown
