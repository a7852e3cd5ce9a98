"""A study: a base scenario, what is varied, what is kept, what is drawn; from a YAML file, checked whole."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from ..errors import InputError
from ..fatigue.curve import Curve, load_curve
from ..inputs import shipped
from ..inputs.schema import check, confirmed_numbers, keyed, quantity, read, unknown
from ..runtime.progress import Progress
from ..scenario import Scenario, assign, change_of, find_beside, load_scenario, scenario_from, suspect, take_in
from ..simulation.places import MOST
from ..verdict.limit_set import DEFAULT_LIMITS, load_limits
from ..wayside.history import window
from . import blind_zone, moving_green_functions, track_receptances, wheelset_modes, wheelset_receptances
from .axes import Axis, Point, combinations, read_axis
from .charts import Lines
from .evaluate import PRESSURES, Job
from .histories import Histories
from .maps import Map
from .outputs import check_output, nodes_of_fatigue
from .pressure_maps import PressureMaps
from .sampling import Sampling
from .sensitivities import Sensitivities

FIGURES: dict[str, Callable[[Path, Scenario, Progress | None], list[Path]]] = {
    "wheelset_receptances": wheelset_receptances.draw,
    "wheelset_modes": wheelset_modes.draw,
    "track_receptances": track_receptances.draw,
    "moving_green_functions": moving_green_functions.draw,
    "blind_zone": blind_zone.draw,
}
"""Figures that are drawn from the models, without runs of the study. A function writes them, and their tables, into a
folder and returns what it wrote."""


@dataclass(frozen=True)
class EvaluationWindow:
    """Track over which a run is evaluated, around the place where angle 0 of the treads meets the rail.

    The default is the paper's: three sleeper bays (Section 5.4), with the defect in their middle.
    """

    before: float = quantity("m", 0.0, 100.0, "the evaluated track before the reference position", default=0.9)
    after: float = quantity("m", 0.0, 10000.0, "the evaluated track after the reference position", default=0.9)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class StudyRun:
    """One run of a study."""

    points: tuple[Point, ...]
    """Its place on each axis."""
    job: Job

    @property
    def scenario(self) -> Scenario:
        """What is simulated."""
        return self.job.scenario

    @property
    def label(self) -> str:
        """Its place on each axis as people read it."""
        return ", ".join(point.label for point in self.points) or self.scenario.name


@dataclass(frozen=True)
class Study:
    """A study: a base scenario, axes to vary, results to keep of each run, and figures to draw.

    ``docs/reference/studies.md`` describes the keys. ``run_study`` runs it.

    Raises
    ------
    InputError
        For axes, outputs or figures that do not exist.

    Examples
    --------
    >>> study = Study(title="Speed", vary={"speed": [20.0, 30.0]}, outputs=("wheels.wheel_1.max_force",))
    >>> [run.scenario.speed for run in study.runs()]
    [20.0, 30.0]
    """

    title: str
    description: str = ""
    scenario: Any = "damage_wheel_1"
    """Name of a shipped scenario, path of a file, or a mapping."""
    set: Any = field(default_factory=dict)
    """Dotted scenario keys that differ from the base scenario in all runs."""
    vary: Any = field(default_factory=dict)
    """Axes, the first varied slowest: see ``axes.read_axis``."""
    sampling: Sampling | None = None
    """How values are drawn along axes that are distributions; ``Sampling()`` if None."""
    window: EvaluationWindow = field(default_factory=EvaluationWindow)
    places: int = quantity("", 1, MOST, "the number of places of the bay at which each run is repeated", default=1)
    """Outputs are medians over them then, with the smallest and the largest beside."""
    outputs: tuple[str, ...] = ()
    """Numbers that are kept: see ``outputs``."""
    histories: tuple[Literal["forces", "principal", "displacements", "irregularity"], ...] = ()
    """What is kept of every step."""
    curve: str | Path = ""
    """Name or file of the S-N curve of outputs of fatigue."""
    pressures: tuple[str, ...] = ()
    """Contact pressures that are kept: ``wheel_1.reference``, ``wheel_1.max_force``, and of wheel 2."""
    limits: str = DEFAULT_LIMITS
    """Limits for the verdict on each run: name of a shipped set, path of a file, or ``none``."""
    drawings: tuple[Lines | Histories | PressureMaps | Map | Sensitivities, ...] = ()
    """Figures of the runs' results."""
    figures: tuple[str, ...] = ()
    """Figures that are drawn from the models, without runs: see ``FIGURES``."""

    def __post_init__(self) -> None:
        check(self)
        for name in ("set", "vary"):
            keyed(getattr(self, name), name)
        if not isinstance(self.scenario, (str, Path, Mapping)):
            raise InputError(f"scenario = {self.scenario!r} is neither a name, nor a file, nor a mapping of its keys")
        for index, name in enumerate(self.figures):
            if name not in FIGURES:
                raise InputError(unknown("figure", f"figures.{index} = {name!r}", name, [*FIGURES]))
        for index, name in enumerate(self.pressures):
            if name not in PRESSURES:
                raise InputError(unknown("contact pressure", f"pressures.{index} = {name!r}", name, PRESSURES))
        load_limits(self.limits)
        if not (self.has_runs or self.figures):
            raise InputError("outputs is missing: name the results to keep, such as wheels.wheel_1.max_force")
        if nodes_of_fatigue(self.outputs) and not self.curve:
            raise InputError("curve is missing: name the S-N curve of the outputs of fatigue, such as assumed_body")
        of_one = [*nodes_of_fatigue(self.outputs), *(name for name in self.outputs if name.startswith("wayside."))]
        if of_one and self.places > 1:
            raise InputError(
                f"places = {self.places} is for forces and stresses, and outputs of fatigue and of detectors are of "
                "one run: give 1"
            )
        axes, _ = self.axes, self.sn_curve  # read now, so that a study that exists can be used
        keys = sorted(key for axis in axes for key in axis.keys)
        for key, following in itertools.pairwise(keys):
            if key == following:
                raise InputError(f"vary changes {key} along two axes: give it in one")
        for index, drawing in enumerate(self.drawings):
            drawing.check(self, f"drawings.{index}")

    @property
    def has_runs(self) -> bool:
        """Whether anything is simulated."""
        return bool(self.outputs or self.histories or self.pressures)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """What is varied."""
        axes = tuple(read_axis(str(name), data, f"vary.{name}") for name, data in self.vary.items())
        drawn = sum(axis.distribution is not None for axis in axes)
        if self.sampling is not None:
            _check_sampling(self.sampling, drawn, len(axes))
        if not drawn:
            return axes
        shares = iter((self.sampling or Sampling()).draws(drawn).T)
        return tuple(axis.drawn(next(shares)) if axis.distribution else axis for axis in axes)

    @cached_property
    def sn_curve(self) -> Curve | None:
        """S-N curve of outputs of fatigue; raises InputError for one that cannot be used."""
        return load_curve(self.curve) if nodes_of_fatigue(self.outputs) else None

    def base(self, changes: Sequence[str] = ()) -> dict[str, Any]:
        """Base scenario as a plain mapping, with the study's changes and then ``key=value`` ones; raises InputError."""
        named = self.scenario
        base = scenario_from(named) if isinstance(named, Mapping) else load_scenario(named)
        data = base.to_mapping()
        for key, value in self.set.items():
            suspect(key, value, f"set.{key}")
            assign(data, key, copy.deepcopy(value), "set.")
        varied = {key for axis in self.axes for key in axis.keys}
        for change in changes:
            if change.partition("=")[0] in varied:
                raise InputError(
                    f"--set {change}: the study varies {change.partition('=')[0]} itself; edit its vary, or leave "
                    "the option out"
                )
            key, value = change_of(change)
            suspect(key, value, f"--set {key}")
            assign(data, key, value, "--set ")
        take_in(data)
        return data

    def runs(self, changes: Sequence[str] = ()) -> tuple[StudyRun, ...]:
        """All runs, the last axis varied fastest; raises InputError for the first that cannot be simulated."""
        if not self.has_runs:
            return ()
        base, axes = self.base(changes), self.axes
        return tuple(self._run(base, axes, points) for points in combinations(axes))

    def _run(self, base: dict[str, Any], axes: tuple[Axis, ...], points: tuple[Point, ...]) -> StudyRun:
        data = copy.deepcopy(base)
        place = ", ".join(f"{axis.name} {point.label}" for axis, point in zip(axes, points, strict=True))
        try:
            for axis, point in zip(axes, points, strict=True):
                for key, value in point.changes:
                    assign(data, key, copy.deepcopy(value), f"vary.{axis.name}: ")
            take_in(data)
            with confirmed_numbers():
                scenario = scenario_from(data)
            kept = (self.outputs, self.histories, self.pressures, self.sn_curve, self.places)
            job = Job(scenario, self.window.before, self.window.after, *kept)
            self._check(job)
        except InputError as refusal:
            raise InputError(f"{refusal} (run {place or data['name']})") from None
        return StudyRun(points, job)

    def _check(self, job: Job) -> None:
        """Raise InputError for what the study asks of a run that it does not have."""
        scenario = job.scenario
        detectors = {
            each.topic.partition("/")[2]: window(each.detector, scenario.track, each.position, scenario.step_length)[1]
            for each in scenario.wayside
        }
        for index, name in enumerate(self.outputs):
            check_output(name, scenario.output.stress_nodes, f"outputs.{index}", [*detectors])
            kind, of, _ = name.split(".")
            if kind == "wayside" and (last := detectors[of]) >= (end := job.first_step + job.samples):
                dx = scenario.step_length
                raise InputError(
                    f"window.after = {self.window.after:g} m ends before the wheelset has passed detector {of}: give "
                    f"{self.window.after + (last + 1 - end) * dx:g} m or more"
                )
        if self.window.before > scenario.reference_position + 1e-9:
            raise InputError(
                f"window.before = {self.window.before:g} m begins before the run: give up to the reference position of "
                f"{scenario.reference_position:g} m, or raise reference_position"
            )


def _check_sampling(sampling: Sampling, drawn: int, axes: int) -> None:
    """Raise InputError for a design that does not fit the axes of a study, of which some are ``drawn``."""
    if not drawn:
        raise InputError("sampling draws from distributions, and vary has none: give one, or leave sampling out")
    if sampling.method == "saltelli" and not 1 < drawn == axes:
        raise InputError(
            "sampling.method = saltelli compares distributions: give two axes or more, each with a distribution"
        )


def load_study(name_or_path: str | Path) -> Study:
    """Load a study.

    Parameters
    ----------
    name_or_path
        Name of a shipped study, such as ``speed``, or path of a YAML file. Its ``scenario`` may be a file beside it.

    Raises
    ------
    InputError
        In one line, for anything that cannot be used.

    Examples
    --------
    >>> [axis.name for axis in load_study("depth").axes]
    ['size', 'irregularities.0.h']
    """
    try:
        data = shipped.load_yaml("studies", name_or_path)
        if isinstance(data, dict) and Path(name_or_path).is_file():
            for key in ("scenario", "curve"):
                find_beside(data, key, Path(name_or_path).parent)
        return read(Study, data, "")
    except InputError as refusal:
        if str(name_or_path) in str(refusal):
            raise
        raise InputError(f"study {name_or_path}: {refusal}") from None
