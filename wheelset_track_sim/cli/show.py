"""``show``: a picture of what a scenario describes, before it is run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError
from ..report.pictures import show_scenario
from ..scenario import load_scenario
from .console import terminal
from .progress import shown


def show(name: str, changes: Sequence[str], out: Path | None) -> int:
    """Write the picture of a scenario; returns the exit status."""
    if out is not None and out.suffix.lower() != ".png":
        raise InputError(f"--out {out} is no picture: give a name that ends in .png")
    scenario = load_scenario(name, changes)
    with shown() as progress:
        path = show_scenario(scenario, out or Path(f"{scenario.name}.png"), progress)
    terminal().print(f"picture {path}", highlight=False, soft_wrap=True)
    return 0
