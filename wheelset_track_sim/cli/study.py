"""``study``: run a parameter study, draw it, sum it up."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table as RichTable

from ..bags.exports import require_libraries
from ..errors import WheelsetTrackError
from ..inputs import shipped
from ..inputs.schema import confirmed_numbers
from ..runtime.progress import Progress
from ..scenario import Scenario, scenario_from
from ..studies.arrays import write_netcdf, write_zarr
from ..studies.conduct import Resources, conduct
from ..studies.results import Results
from ..studies.study import FIGURES, Study, StudyRun, load_study
from ..studies.summary_page import write_summary
from ..studies.tables import ResultTable, tables, write_tables
from .console import terminal
from .progress import shown

ALL = "all"
"""The name that means every shipped study."""
RESULTS = Path("results")


@dataclass(frozen=True)
class Task:
    """One study, checked, with its folder."""

    name: str
    study: Study
    scenario: Scenario
    runs: tuple[StudyRun, ...]
    out: Path


FORMS: dict[str, tuple[tuple[str, ...], Callable[[Results, Path], Path]]] = {
    "netcdf": (("xarray",), write_netcdf),
    "zarr": (("xarray", "zarr"), write_zarr),
}
"""Forms of all results together: the libraries that each needs, and what writes it."""


def study(
    name: str,
    changes: Sequence[str],
    out: Path | None,
    resources: Resources,
    forms: Collection[str] = (),
    *,
    places: int | None = None,
) -> int:
    """Run a study, or all shipped ones, and print what came out; returns the exit status.

    Raises InputError before anything runs for whatever cannot be used in any of them.
    """
    require_forms(forms)
    names = shipped.names("studies") if name == ALL else [name]
    tasks = [task(each, changes, out / each if out and name == ALL else out, places) for each in names]
    return carry_out(tasks, resources, forms)


def require_forms(forms: Collection[str]) -> None:
    """Raise InputError for a form of results, such as ``parquet``, whose libraries are not installed."""
    for form in forms:
        require_libraries(f"--{form}", ("pandas", "pyarrow") if form == "parquet" else FORMS[form][0])


def carry_out(tasks: Sequence[Task], resources: Resources, forms: Collection[str]) -> int:
    """Run tasks and print what came out; returns the exit status. Raises WheelsetTrackError if runs failed."""
    console = terminal()
    failed = sum(_carry_out(each, resources, console, forms) for each in tasks)
    if failed:
        raise WheelsetTrackError(
            f"{failed} run{'s' * (failed > 1)} failed, see above; the results of the others are kept"
        )
    return 0


def task(name: str, changes: Sequence[str], out: Path | None, places: int | None = None) -> Task:
    """A study with all its scenarios, at another number of places if given; raises InputError."""
    what = load_study(name)
    if places is not None:
        what = dataclasses.replace(what, places=places)
    return task_of(Path(name).stem, what, changes, out)


def task_of(short: str, what: Study, changes: Sequence[str], out: Path | None) -> Task:
    """The same of a study and its name."""
    runs = what.runs(changes)
    with confirmed_numbers():
        scenario = scenario_from(what.base(changes))
    return Task(short, what, scenario, runs, out or RESULTS / _folder(short, scenario, runs, changes))


def _folder(name: str, scenario: Scenario, runs: Sequence[StudyRun], changes: Sequence[str]) -> str:
    """Name of the folder: study, dynamics, and what else was changed."""
    dynamics = sorted({run.scenario.dynamics for run in runs} or {scenario.dynamics})
    others = [change for change in changes if not change.startswith("dynamics=")]
    return "-".join([name, *dynamics, *(re.sub(r"[^\w.]+", "_", change).strip("_") for change in others)])


def _carry_out(task: Task, resources: Resources, console: Console, forms: Collection[str]) -> int:
    """Run, draw, write and print one study; returns how many runs failed."""
    with shown() as progress:
        results, there = conduct(task.name, task.study, task.runs, task.out, resources, progress)
        files = _draw(task, results, progress, parquet="parquet" in forms)
        arrays = [FORMS[form][1](results, task.out) for form in forms if form in FORMS and task.study.outputs]
    found = list(tables(results))
    made_by = results.made_by if task.runs else f"Scenario {task.scenario.name}, {task.scenario.dynamics} dynamics"
    pages = write_summary(task.out, task.study.title, task.study.description, made_by, found, files)
    if there:
        console.print(f"{there} of {len(task.runs)} runs were there already", highlight=False)
    for table in found:
        console.print(_for_terminal(table, task.study.title))
    pictures = [path for path in files if path.suffix == ".png"]
    if results.note:
        console.print(results.note, highlight=False)
    for path in (*pictures, *pages):
        console.print(f"{'picture' if path in pictures else 'summary'} {path}", highlight=False, soft_wrap=True)
    for path in arrays:
        console.print(f"arrays {path}", highlight=False, soft_wrap=True)
    return len(results.failures)


def _draw(task: Task, results: Results, progress: Progress, *, parquet: bool) -> list[Path]:
    files: list[Path] = []
    drawings = len(task.study.drawings)
    for number, drawing in enumerate(task.study.drawings):
        files += drawing.draw(results, task.out)
        progress(f"draw {task.name}", (number + 1) / drawings)
    for name in task.study.figures:
        files += FIGURES[name](task.out, task.scenario, progress)
    return files + (write_tables(results, task.out, parquet=parquet) if task.runs else [])


def _for_terminal(table: ResultTable, title: str) -> RichTable:
    printed = RichTable(title=f"{title}\n{table.title}", title_justify="left")
    for column, heading in enumerate(table.headings):
        printed.add_column(heading, justify="left" if column == 0 else "right", overflow="fold")
    for row in table.rows:
        printed.add_row(*row)
    return printed
