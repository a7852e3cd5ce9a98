"""``show``: a picture of what a scenario describes, before it is run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..report.figures import check_picture
from ..report.pictures import show_scenario
from ..runtime.output_files import file_name, require_new
from ..scenario import load_scenario
from .console import terminal
from .progress import shown


def show(name: str, changes: Sequence[str], out: Path | None, *, overwrite: bool) -> int:
    """Write the picture of a scenario; returns the exit status."""
    if out is not None:
        check_picture(out)
    scenario = load_scenario(name, changes)
    picture = out or Path(f"{file_name(scenario.name)}.png")
    require_new([picture], overwrite=overwrite)
    with shown() as progress:
        show_scenario(scenario, picture, progress)
    terminal().print(f"picture {picture}", highlight=False, soft_wrap=True)
    return 0
