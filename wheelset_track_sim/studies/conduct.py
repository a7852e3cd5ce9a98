"""Running a study: what is stored is taken, the rest is simulated and stored as it ends."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ..errors import InputError, WheelsetTrackError
from ..runtime.cores import cores
from ..runtime.progress import Progress
from ..simulation.models import load_models
from .evaluate import Job, Result, evaluate, program
from .results import Results
from .store import Store
from .study import Study, StudyRun
from .workers import on_cluster, on_this_machine

RUNS = "runs"
"""Folder of finished runs within the study's."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Resources:
    """Where runs are simulated."""

    workers: int | None = None
    """Processes on this machine; one a core if None."""
    scheduler: str | None = None
    """Address of a Dask scheduler, whose workers then do all runs."""

    def __post_init__(self) -> None:
        if self.workers is not None and not 1 <= self.workers <= 1024:
            raise InputError(f"--workers {self.workers} is out of range: give a number from 1 to 1024")
        if self.workers is not None and self.scheduler is not None:
            raise InputError(
                "--workers applies to this machine, and a --scheduler has its own workers: give one of them"
            )


def run_study(
    study: Study,
    out: str | Path,
    changes: Sequence[str] = (),
    *,
    resources: Resources | None = None,
    progress: Progress | None = None,
) -> Results:
    """Run a study: simulate what is not stored yet, and return the results of all its runs.

    Parameters
    ----------
    study
        From ``load_study``, or made in Python.
    out
        Folder in which finished runs are stored; a run that is there is not simulated again.
    changes
        ``key=value`` changes of the base scenario, as with ``--set``.
    resources
        Number of worker processes, or a Dask scheduler; one process a core if None. Workers import the script that
        called this: guard its body with ``if __name__ == "__main__":``.
    progress
        Called with stage and fraction.

    Returns
    -------
    Results
        ``value(index, output)`` gives a number of a run, SI; ``failures`` names the runs that failed.

    Raises
    ------
    InputError
        For a change or a folder that cannot be used; nothing has run then.

    Examples
    --------
    >>> study = Study(
    ...     title="Depth",
    ...     scenario="damage_wheel_1",
    ...     vary={"irregularities.0.h": [0.0005, 0.002]},
    ...     outputs=("wheels.wheel_1.max_force",),
    ... )
    >>> results = run_study(study, "depths")
    >>> [round(results.value(run, "wheels.wheel_1.max_force") / 1e3) for run in (0, 1)]  # kN
    [230, 291]
    """
    folder = Path(out)
    return conduct(folder.name, study, study.runs(changes), folder, resources or Resources(), progress)[0]


def conduct(
    name: str, study: Study, runs: Sequence[StudyRun], out: Path, resources: Resources, progress: Progress | None = None
) -> tuple[Results, int]:
    """Results of a study whose folder is ``out``, and how many runs were there already.

    A run that fails is reported and told in the results. Raises InputError for a folder that cannot be written and
    models that cannot be built.
    """
    store = Store(out / RUNS)
    try:
        (store.folder if runs else out).mkdir(parents=True, exist_ok=True)
        store.tidy()
    except OSError as reason:
        raise InputError(f"{out} cannot be written ({reason.strerror}): give another folder with --out") from None
    keys = [run.job.digest() for run in runs]
    found = {index: result for index, key in enumerate(keys) if (result := store.load(key)) is not None}
    there = len(found)
    missing = sorted(set(range(len(runs))) - set(found), key=lambda index: -runs[index].job.effort)
    failures: dict[int, str] = {}

    def tell(ended: int) -> None:
        if progress:
            progress(f"study {name}, {ended} of {len(runs)} runs", ended / len(runs))

    if missing and resources.scheduler is None:
        with suppress(WheelsetTrackError):  # of which the run itself will tell
            # Once for all: the workers then find most of the models in the cache.
            load_models(runs[missing[0]].scenario, progress, tables="smooth")
    if runs:
        tell(there)
    for index, ended in _done({index: runs[index].job for index in missing}, resources):
        if isinstance(ended, Result):
            store.save(keys[index], ended, f"study {name}, run {runs[index].label}")
            found[index] = ended
        else:
            failures[index] = _told(ended)
            log.error("run %s failed: %s", runs[index].label, failures[index])
            if not isinstance(ended, WheelsetTrackError):
                log.debug("run %s", runs[index].label, exc_info=ended)
        tell(len(found) + len(failures))
    return Results(name, study, tuple(runs), dict(sorted(found.items())), failures), there


def _done(jobs: Mapping[int, Job], resources: Resources) -> Iterator[tuple[int, Result | Exception]]:
    if not jobs:
        return iter(())
    work: Callable[[Job], Result] = partial(evaluate, made_for=program())
    if resources.scheduler is not None:
        return on_cluster(work, jobs, resources.scheduler)
    return on_this_machine(work, jobs, min(resources.workers or cores(), len(jobs)))


def _told(failure: Exception) -> str:
    """A failure in one line."""
    text = " ".join(str(failure).split())
    return text if isinstance(failure, WheelsetTrackError) else f"{type(failure).__name__}: {text}"
