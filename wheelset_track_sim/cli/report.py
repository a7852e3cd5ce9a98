"""``report``: a page, a picture and a table of a bag."""

from __future__ import annotations

from pathlib import Path

from ..bags import Bag
from ..bags.bag_reader import beside
from ..errors import InputError
from ..fatigue.axle import POINTS
from ..fatigue.curve import load_curve
from ..report import plot_run, summary_table, survey
from ..report.figures import check_picture
from ..runtime.output_files import require_new
from ..samples.impacts import ImpactSettings
from ..twin.measured import Matching, Reading, compare, read_measurement
from ..verdict.limit_set import DEFAULT_LIMITS, load_limits
from .console import terminal
from .fatigue import counted


def report(
    bag: Path,
    out: Path | None,
    settings: ImpactSettings | None = None,
    measured: Path | None = None,
    matching: Matching | None = None,
    reading: Reading | None = None,
    *,
    picture: Path | None = None,
    overwrite: bool = False,
    limits: str = DEFAULT_LIMITS,
    curve: str | None = None,
) -> int:
    """Write the page and the picture, by default next to it, print the table; returns the exit status.

    ``measured`` is a file of measured loads or stresses, which the page shows beside the run; ``reading`` and
    ``matching`` say how to read it and where it lies. Without ``out`` the page is beside the bag. ``limits`` is the set
    for the verdict, and ``curve`` an S-N curve with which fatigue is counted.
    """
    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out {out} is not a page: give a name that ends in .html")
    try:
        from ..report.page import write_report
    except ModuleNotFoundError as missing:
        if not (missing.name or "").startswith("bokeh"):
            raise
        raise InputError("the page needs bokeh, which is not installed: run make setup, or pip install bokeh") from None
    limit_set = load_limits(limits)
    page = out or beside(bag, ".html")
    picture = picture or page.with_suffix(".png")
    check_picture(picture)
    require_new([page, picture], overwrite=overwrite)
    counted_fatigue = None
    if curve is not None:
        counted_fatigue, _ = counted(str(bag), [], load_curve(curve), None, angles=POINTS, gate=None)
    run = survey(bag, settings, limit_set)
    comparison = None
    if measured is not None:
        comparison = compare(Bag(bag).blocks(), read_measurement(measured, reading), matching)
    console = terminal()
    console.print(summary_table(run))
    for loss in run.losses:
        console.print(f"lost: {loss}", highlight=False, soft_wrap=True)
    plot_run(run, picture)
    write_report(run, page, comparison, counted_fatigue)
    console.print(f"picture {picture}\npage    {page}", highlight=False, soft_wrap=True)
    return 0
