"""Progress of slow work on standard error: one bar for people, a line now and then in a log."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import Progress as Bars
from rich.progress import ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.table import Column
from rich.text import Text

from ..errors import printable
from ..runtime.progress import Progress
from .console import terminal

WIDTH = 20
"""Characters of the bar."""
PERIOD = 30.0
"""Time from line to line in a log while one job goes on, s."""
MEMORY = 600.0
"""Time over which the pace is estimated, s: runs of a study take minutes."""


class _Bar(ProgressColumn):
    """``[#####.....]``, which is read without colour, too."""

    def render(self, task: Task) -> Text:
        done = int(WIDTH * task.completed)
        return Text(f"[{'#' * done}{'.' * (WIDTH - done)}]")


class _Log:
    """Lines in a log: one at the end of each job, and one now and then while it lasts."""

    def __init__(self, write: Callable[[str], None], clock: Callable[[], float]) -> None:
        self._write, self._clock = write, clock
        self._stage, self._share = "", 2.0
        self._from, self._began, self._told = 0.0, 0.0, 0.0

    def __call__(self, stage: str, share: float) -> None:
        now = self._clock()
        if share < self._share or (self._share >= 1.0 and stage != self._stage):  # another job
            self._from, self._began, self._told = share, now, now
        ended = share >= 1.0 and (self._share < 1.0 or stage != self._stage)
        self._stage, self._share = stage, share
        if ended:
            self._write(f"{stage}: done")
        elif share < 1.0 and now - self._told >= PERIOD:
            self._told = now
            gone = share - self._from
            left = f", {duration((now - self._began) * (1.0 - share) / gone)} left" if gone > 0 else ""
            self._write(f"{stage}: {share:.0%}{left}")


def duration(seconds: float) -> str:
    """A time as ``m:ss`` or ``h:mm:ss``."""
    minutes, left = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{left:02}" if hours else f"{minutes}:{left:02}"


@contextmanager
def shown(clock: Callable[[], float] = time.monotonic) -> Iterator[Progress]:
    """Callback ``(stage, share)`` that shows how far work is.

    On a terminal it is one bar with stage, share and time left, which goes away at the end. Stages follow each other
    within a job as long as the share does not fall. In a log it is a line for each job, and one every ``PERIOD``.
    """
    console = terminal(stderr=True)
    if not console.is_terminal:
        yield _Log(lambda line: console.print(line, highlight=False, soft_wrap=True), clock)
        return
    what = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, overflow="ellipsis"))
    share = TextColumn("{task.percentage:>3.0f} %", markup=False)
    left = TextColumn("left", markup=False)
    columns = (what, _Bar(Column(min_width=WIDTH + 2, no_wrap=True)), share, TimeRemainingColumn(), left)
    with Bars(*columns, console=console, transient=True, speed_estimate_period=MEMORY) as bars:
        task = bars.add_task("", total=1.0)

        def bar(stage: str, share: float) -> None:
            if share < bars.tasks[0].completed:
                bars.reset(task)
            bars.update(task, description=printable(stage), completed=share)

        yield bar
