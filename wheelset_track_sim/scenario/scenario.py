"""What is simulated: one frozen, checked description, from a YAML file and ``key=value`` changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from ..contact.profile_points import FILES, load_points
from ..errors import InputError
from ..inputs.schema import Quantity, check, plain, quantity, read
from ..inputs.shipped import MAX_DEPTH, load_yaml
from ..inputs.yaml12 import dump, parse
from ..irregularities import AnyIrregularity, line_steps
from ..irregularities.listing import MOST
from ..irregularities.surface import LONGEST_LINE
from ..runtime.cache import digest
from .loads import Loads

Wheel = Literal["wheel_1", "wheel_2"]
WHEELS: tuple[Wheel, Wheel] = ("wheel_1", "wheel_2")

BAND = Quantity("Hz", 100.0, 10000.0, "the band limit")
GAUGE = Quantity("m", 0.9, 1.8, "the gauge")
LINE = Quantity("m", 0.5, LONGEST_LINE, "the length after which rails repeat")

LAG_ZERO = {"causal": ("residual", "wheel_residual", "zero"), "paper": ("printed", "zero", "folded")}
"""Variants of each dynamics at lag zero, the default first."""


@dataclass(frozen=True)
class Output:
    """What is kept of a run."""

    stress_nodes: tuple[str, ...] = ("A1", "B1", "C1")

    def __post_init__(self) -> None:
        twice = [name for name in self.stress_nodes if self.stress_nodes.count(name) > 1]
        if twice:
            raise InputError(f"output.stress_nodes names {twice[0]} twice: give each once, a topic of its own")


@dataclass(frozen=True)
class SetPoint:
    """A speed that is approached from a time on."""

    time: float = quantity("s", 0.0, 1e6, "the time since the start")
    speed: float = quantity("m/s", 5.0, 100.0, "the speed that is approached")

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Profiles:
    """Lateral profiles of wheels and rails, each a name, a file or a mapping of points; ``docs/profiles.md``."""

    wheel_1: Any = "cylinder"
    wheel_2: Any = "cylinder"
    rail_1: Any = "head_60e1"
    rail_2: Any = "head_60e1"
    inclination: float = quantity(
        "", 0.0, 0.1, "the inclination of the rails to the middle of the track, such as 1/40 = 0.025", default=0.0
    )
    gauge: float | None = None
    """Distance of the rails, m, 14 mm below their tops; if None, each rolling circle is over the middle of its rail."""

    def __post_init__(self) -> None:
        check(self, "profiles")
        refusal = None if self.gauge is None else GAUGE.refusal("profiles.gauge", self.gauge)
        if refusal:
            raise InputError(refusal)


@dataclass(frozen=True)
class Scenario:
    """A wheelset on a track at a speed, or at several one after the other, with its irregularities. SI units."""

    name: str
    speed: float = quantity("m/s", 5.0, 100.0, "the running speed")
    """At the start; changed during a run, the speed that is approached from then on."""
    axle_load: float = quantity("N", 2e4, 4e5, "the static load on both wheels together")
    dynamics: Literal["causal", "paper"] = "causal"
    """``causal``: modal state space, which streams; ``paper``: Green's functions as printed, the reference."""
    wheelset: Any = "x40"
    """Name of a shipped wheelset, path of a file, or a mapping."""
    track: Any = "ballasted_60e1"
    """Name of a shipped track, path of a file, or a mapping."""
    irregularities: tuple[AnyIrregularity, ...] = ()
    """Of treads and rails; where several lie, their heights add up."""
    line_length: float | None = None
    """Length after which the irregularities of the rails repeat, m; None is 60 m, or as often that as they need."""
    loads: Loads = field(default_factory=Loads)
    """What is superposed on the axle's stress beside the contact forces; nothing by default."""
    profiles: Profiles = field(default_factory=Profiles)
    lateral_offset: float = quantity(
        "m", -0.020, 0.020, "the distance of the wheelset from the middle of the track, to the left", default=0.0
    )
    """Constant during a run, as in the paper (Section 2.3)."""
    output: Output = field(default_factory=Output)
    reference_position: float = quantity(
        "m", 0.6, 6.0, "the position along the track where angle 0 of both treads first meets the rail", default=1.8
    )
    acceleration: float = quantity("m/s^2", 0.01, 10.0, "the acceleration to a set point of the speed", default=0.5)
    """Up and down. The default is what passenger trains do in ordinary service; an emergency brake has 1 to 2.5."""
    speed_plan: tuple[SetPoint, ...] = ()
    """Set points of the speed in the order of their times; a change of ``speed`` during the run ends the plan."""
    step_length: float = quantity("m", 2e-4, 2e-3, "the length of a step and of a contact element", default=1e-3)

    max_frequency: float | None = None
    """Band limit, Hz: of the receptances (``paper``, 2500 if None), or of the modes that are kept (``causal``; if None,
    6000 of the wheelset and 5000 of the track)."""
    lag_zero: Literal["default", "residual", "wheel_residual", "printed", "zero", "folded"] = "default"
    """What a force displaces at its own instant; ``docs/validation.md`` compares them.

    ``causal``: ``residual`` (default) is the rail's static residual, ``wheel_residual`` adds the wheelset's, ``zero``
    has neither. ``paper``: ``printed`` (default) is the first rail value of Eq. (3), ``zero`` leaves it out, ``folded``
    folds what the band limit puts before t = 0 onto t > 0.
    """

    def __post_init__(self) -> None:
        check(self)
        if not self.name:
            raise InputError("name is empty: give the scenario a name")
        for name, limits in (("max_frequency", BAND), ("line_length", LINE)):
            refusal = None if getattr(self, name) is None else limits.refusal(name, getattr(self, name))
            if refusal:
                raise InputError(refusal)
        if len(self.irregularities) > MOST:
            raise InputError(f"irregularities has {len(self.irregularities)} entries: give at most {MOST}")
        _ = self.line_steps
        for index, (before, after) in enumerate(pairwise(self.speed_plan)):
            if after.time <= before.time:
                raise InputError(
                    f"speed_plan.{index + 1}.time = {after.time:g} s is not behind the {before.time:g} s of the set "
                    f"point before: give times that increase"
                )
        if self.speed_plan and self.dynamics == "paper":
            raise InputError("speed_plan cannot be followed in paper dynamics, whose speed is constant: use causal")
        known = LAG_ZERO[self.dynamics]
        if self.lag_zero not in ("default", *known):
            raise InputError(f"lag_zero = {self.lag_zero} is not of {self.dynamics} dynamics: give {', '.join(known)}")

    @property
    def wheel_load(self) -> float:
        """Static load on each wheel, N."""
        return self.axle_load / 2

    @property
    def step_period(self) -> float:
        """Time of one step at ``speed``, s: ``dt = dx / v``."""
        return self.step_length / self.speed

    @property
    def line_steps(self) -> int:
        """Steps after which the irregularities of the rails repeat; 1 without any."""
        return line_steps(self.irregularities, self.line_length, self.step_length)

    @property
    def at_lag_zero(self) -> str:
        """The variant at lag zero, the default named."""
        return LAG_ZERO[self.dynamics][0] if self.lag_zero == "default" else self.lag_zero

    def to_mapping(self) -> dict[str, Any]:
        """Plain mapping that ``scenario_from`` turns into an equal scenario."""
        return {**plain(self), "loads": self.loads.to_mapping()}

    def to_yaml(self) -> str:
        """The scenario as a YAML file's text."""
        return self._yaml

    @cached_property
    def _yaml(self) -> str:
        return dump(self.to_mapping())  # in 2 ms: a run of many changes is told often

    @property
    def digest(self) -> str:
        """Digest of all that the scenario says; names of models count as names."""
        return digest(self.to_mapping())


def load_scenario(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """Scenario from a shipped name or a file, with ``dotted.key=value`` changes (list indices count from 0).

    Raises InputError in one line for anything that cannot be used.
    """
    data = load_yaml("scenarios", name_or_path)
    if not isinstance(data, dict):
        raise InputError(f"{name_or_path} is not a mapping of scenario keys: see the shipped scenarios")
    if Path(name_or_path).is_file():
        _find_beside(data, Path(name_or_path).parent)
    for change in overrides:
        override(data, change)
    take_in(data)
    return scenario_from(data)


def _find_beside(data: dict[str, Any], folder: Path) -> None:
    """Let the files that a plain scenario names be found in the folder of its own, too, from wherever it is run."""
    places: list[tuple[Any, str]] = [(data, "wheelset"), (data, "track"), (data.get("track"), "base")]
    profiles, irregularities = data.get("profiles"), data.get("irregularities")
    places += [(profiles, surface) for surface in (profiles if isinstance(profiles, dict) else ())]
    places += [(item, "file") for item in (irregularities if isinstance(irregularities, list) else ())]
    for place, key in places:
        name = place.get(key) if isinstance(place, dict) else None
        if isinstance(name, str) and Path(name).suffix and (folder / name).is_file():
            place[key] = str(folder / name)


def take_in(data: dict[str, Any]) -> None:
    """Put the content of files of the user's in the place of their names, so that a scenario needs no other file."""
    _take_in_model(data, "wheelset", "wheelsets")
    _take_in_model(data, "track", "tracks")
    profiles = data.get("profiles")
    if not isinstance(profiles, dict):
        return
    for surface, given in profiles.items():
        if isinstance(given, str) and Path(given).suffix in FILES:
            profiles[surface] = load_points(surface.partition("_")[0], given).plain()


def _take_in_model(place: Any, key: str, kind: str, depth: int = 0) -> None:
    """Put the content of a model's file in the place of its name, and that of the files on which it stands."""
    name = place.get(key) if isinstance(place, dict) else None
    if isinstance(name, str) and Path(name).suffix in (".yaml", ".yml", ".npz"):
        place[key] = load_yaml(kind, name)
    if isinstance(place, dict) and depth < MAX_DEPTH:
        _take_in_model(place.get(key), "base", kind, depth + 1)


def scenario_from(data: Mapping[str, Any]) -> Scenario:
    """Scenario from a plain mapping; raises InputError."""
    return read(Scenario, data, "")


def override(data: dict[str, Any], change: str) -> None:
    """Set one entry of nested mappings and lists by ``dotted.key=value``; the value is read as YAML."""
    key, equals, text = change.partition("=")
    if not equals or not key:
        raise InputError(f"--set {change!r} is not of the form key=value, such as speed=30 or irregularities.0.h=0.001")
    assign(data, key, parse(text, f"the value of --set {key}"), "--set ")


def assign(data: dict[str, Any], key: str, value: Any, where: str = "") -> None:
    """Set one entry of a scenario's plain mapping by its dotted key; ``where`` stands before the key in messages.

    A key within a track or wheelset that is named makes its content part of the scenario.
    """
    model, dot, _ = key.partition(".")
    if dot and model in ("track", "wheelset") and isinstance(data.get(model), str):
        data[model] = load_yaml(f"{model}s", data[model])
    *path, last = key.split(".")
    place: Any = data
    for depth, part in enumerate(path):
        place = _entry(place, part, where + ".".join(path[: depth + 1]))
    if isinstance(place, list):
        place[_index(place, last, where + key)] = value
    elif isinstance(place, dict):
        place[last] = value
    else:
        raise InputError(f"{where}{key}: {'.'.join(path)} has no entries")


def _entry(place: Any, part: str, where: str) -> Any:
    if isinstance(place, list):
        return place[_index(place, part, where)]
    if isinstance(place, dict):
        return place.setdefault(part, {})
    raise InputError(f"{where}: there is nothing to set there")


def _index(place: list[Any], part: str, where: str) -> int:
    if not part.isdigit() or int(part) >= len(place):
        raise InputError(f"{where}: {part!r} is not an index of a list with {len(place)} entries (0 is the first)")
    return int(part)
