"""``report``: a page, a picture and a table of a bag."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from ..errors import InputError
from ..report import plot_run, summary_table, survey
from ..simulation.impacts import ImpactSettings


def report(bag: Path, out: Path | None, settings: ImpactSettings | None = None) -> int:
    """Write the page and the picture, print the table; returns the exit status."""
    try:
        from ..report.page import write_report
    except ModuleNotFoundError as missing:
        if not (missing.name or "").startswith("bokeh"):
            raise
        raise InputError("the page needs bokeh, which is not here: run make setup, or pip install bokeh") from None
    page = out or bag.with_suffix(".html")
    run = survey(bag, settings)
    console = Console()
    console.print(summary_table(run))
    picture = page.with_suffix(".png")
    plot_run(run, picture)
    write_report(run, page)
    console.print(f"picture {picture}\npage    {page}", highlight=False, soft_wrap=True)
    return 0
