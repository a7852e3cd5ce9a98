"""Figures that are drawn from the models, without runs: one function each, imported when it is asked for.

A function is ``draw(out: Path, scenario: Scenario, progress: Progress | None) -> list[Path]``: it
writes its figures and tables into ``out`` and returns what it wrote.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from ..errors import InputError
from ..inputs.schema import unknown
from ..runtime.progress import Progress
from ..scenario import Scenario

Draw = Callable[[Path, Scenario, Progress | None], list[Path]]

FIGURES = {
    name: f"wheelset_track_sim.studies.{name}:draw"
    for name in ("wheelset_receptances", "wheelset_modes", "track_receptances", "moving_green_functions")
}


def check_figure(name: str, where: str) -> None:
    """Raise InputError for a figure that is not registered."""
    if name not in FIGURES:
        raise InputError(unknown("figure", f"{where} = {name!r}", name, [*FIGURES]))


def figure(name: str) -> Draw:
    """Function that draws the figure of a registered name."""
    module, _, function = FIGURES[name].partition(":")
    draw: Draw = getattr(import_module(module), function)
    return draw
