"""``report``: a page, a picture and a table of a bag."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from ..recording import read
from ..report import plot_run, summary_table, write_report


def report(bag: Path, out: Path | None) -> int:
    """Write the page and the picture, print the table; returns the exit status."""
    page = out or bag.with_suffix(".html")
    recording = read(bag)
    console = Console()
    console.print(summary_table(recording))
    picture = page.with_suffix(".png")
    plot_run(recording, picture)
    write_report(recording, page)
    console.print(f"picture {picture}\npage    {page}", highlight=False, soft_wrap=True)
    return 0
