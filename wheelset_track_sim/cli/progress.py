"""Progress of slow work on standard error: a bar for people, nothing in a log."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from ..errors import printable
from .console import terminal


@contextmanager
def shown() -> Iterator[Callable[[str, float], None]]:
    """Callback ``(stage, fraction)`` that draws one bar a stage; on a stream that is no terminal, one line a stage."""
    console = terminal(stderr=True)
    if not console.is_terminal:
        finished: set[str] = set()

        def line(stage: str, fraction: float) -> None:
            if fraction >= 1 and stage not in finished:
                finished.add(stage)
                console.print(f"{stage}: done", highlight=False)

        yield line
        return
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as bars:
        tasks = {}

        def bar(stage: str, fraction: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(printable(stage), total=1.0)
            bars.update(tasks[stage], completed=fraction)

        yield bar
