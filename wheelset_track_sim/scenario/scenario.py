"""What is simulated: one frozen description, typed and checked whole when it is made."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from ..contact.geometry import ContactGeometry
from ..contact.law import rolling_surfaces
from ..errors import InputError
from ..inputs.schema import check, parsed, plain, quantity, unknown
from ..inputs.yaml12 import dump
from ..irregularities import Irregularity, line_steps, plain_irregularities, read_irregularities
from ..irregularities.kinds import check_number
from ..irregularities.surface import LONGEST_LINE, Surface, check_length
from ..runtime.cache import digest
from ..sensors.kinds import Sensor, check_sensors
from ..track.supports import LONGEST_STEP
from ..track.track import Track, load_track, plain_track, read_track
from ..wayside.detector import WaysideDetector, check_detectors
from ..wheelset.imported import ImportedWheelset
from ..wheelset.kinds import AnyWheelset, load_wheelset, plain_wheelset, primary_suspension, read_wheelset
from ..wheelset.vehicle import Vehicle, plain_vehicle, read_vehicle
from .contact import ContactOptions
from .events import USUAL_LOAD, USUAL_SPEED, Event, check_events, plain_events, read_events
from .loads import Loads
from .profiles import Profiles

Wheel = Literal["wheel_1", "wheel_2"]
WHEELS: tuple[Wheel, Wheel] = ("wheel_1", "wheel_2")

WHEELSET, TRACK = "x40", "ballasted_60e1"
"""Names of the shipped models that a scenario has if it names none."""
PAPER_BAND = 2500.0
"""Band limit of the receptances in ``paper`` dynamics, Hz, if a scenario gives none (Section 3)."""
LAG_ZERO = {"causal": ("residual", "wheel_residual", "zero"), "paper": ("printed", "zero", "folded")}
"""Variants of each dynamics at lag zero, the default first."""

MIDDLE = np.zeros(1)


@dataclass(frozen=True)
class Output:
    """What is kept of a run."""

    stress_nodes: tuple[str, ...] = ("A1", "B1", "C1")

    def __post_init__(self) -> None:
        twice = [name for name in self.stress_nodes if self.stress_nodes.count(name) > 1]
        if twice:
            raise InputError(f"output.stress_nodes names {twice[0]} twice: give each stress node once")


@dataclass(frozen=True)
class SetPoint:
    """A speed that is approached from a time on."""

    time: float = quantity("s", 0.0, 1e6, "the time since the start")
    speed: float = quantity("m/s", 5.0, 100.0, "the speed that is approached", usual=USUAL_SPEED)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Scenario:
    """A wheelset on a track at a speed, or at several one after the other, with its irregularities. SI units.

    Everything is typed, and checked together when a scenario is made: what exists can be simulated. ``load_scenario``
    reads one from a file; ``dataclasses.replace`` makes another one from it.

    Raises
    ------
    InputError
        In one line with the dotted key, for any value that cannot be used, by itself or with the others.

    Examples
    --------
    >>> scenario = load_scenario("damage_wheel_1")
    >>> faster = dataclasses.replace(scenario, name="faster", speed=40.0)
    >>> faster.track.rail.EI, faster.wheelset.name, faster.irregularities[0].h
    (6405000.0, 'x40', 0.002)
    """

    name: str
    speed: float = quantity("m/s", 5.0, 100.0, "the running speed", usual=USUAL_SPEED)
    """At the start; changed during a run, the speed that is approached from then on."""
    axle_load: float = quantity("N", 2e4, 4e5, "the static load on both wheels together", usual=USUAL_LOAD)
    dynamics: Literal["causal", "paper"] = "causal"
    """``causal``: modal state space, which streams; ``paper``: Green's functions as printed, the reference."""
    wheelset: AnyWheelset = parsed(read_wheelset, plain_wheelset, default_factory=partial(load_wheelset, WHEELSET))
    """In files: the name of a shipped wheelset, the path of a file, or a mapping."""
    track: Track = parsed(read_track, plain_track, default_factory=partial(load_track, TRACK))
    """In files: the name of a shipped track, the path of a file, or a mapping."""
    vehicle: Vehicle | None = parsed(read_vehicle, plain_vehicle, default=None)
    """Bogie frame and car body above the primary suspension; None holds its upper ends. In files like ``track``."""
    irregularities: tuple[Irregularity, ...] = parsed(read_irregularities, plain_irregularities, default=())
    """Of treads and rails; where several lie, their heights add up."""
    line_length: float | None = quantity("m", 0.5, LONGEST_LINE, "the length after which rails repeat", default=None)
    """None is 60 m, or as often that as the irregularities of the rails need."""
    loads: Loads = field(default_factory=Loads)
    """What is superposed on the axle's stress beside the contact forces; nothing by default."""
    profiles: Profiles = field(default_factory=Profiles)
    lateral_offset: float = quantity(
        "m", -0.020, 0.020, "the distance of the wheelset from the middle of the track, to the left", default=0.0
    )
    """Constant during a run, as in the paper (Section 2.3)."""
    contact: ContactOptions = field(default_factory=ContactOptions)
    """Linear elastic by default."""
    output: Output = field(default_factory=Output)
    sensors: tuple[Sensor, ...] = ()
    """What is measured on the wheelset beside the contact forces and stresses."""
    wayside: tuple[WaysideDetector, ...] = ()
    """Detectors beside the track, which the wheelset passes."""
    reference_position: float = quantity(
        "m", 0.6, 6.0, "the position along the track where angle 0 of both treads first meets the rail", default=1.8
    )
    acceleration: float = quantity("m/s^2", 0.01, 10.0, "the acceleration to a set point of the speed", default=0.5)
    """Up and down. The default is what passenger trains do in ordinary service; an emergency brake has 1 to 2.5."""
    speed_plan: tuple[SetPoint, ...] = ()
    """Set points of the speed in the order of their times; a change of ``speed`` during the run ends the plan."""
    events: tuple[Event, ...] = parsed(read_events, plain_events, default=())
    """What changes over the run, in its order; of a scenario in force, what is still to come."""
    step_length: float = quantity("m", 2e-4, 2e-3, "the length of a step and of a contact element", default=1e-3)

    settle_on: Literal["surfaces", "smooth"] = "surfaces"
    """What the wheels run on before step 0. ``surfaces``: those of the scenario, as in a train that runs for a while.
    ``smooth``: a defect meets the rail for the first time after step 0, as in the paper (Section 5.1), and always in
    ``paper`` dynamics."""

    max_frequency: float | None = quantity("Hz", 100.0, 10000.0, "the band limit", default=None)
    """Of the receptances (``paper``, 2500 if None), or of the modes that are kept (``causal``; if None,
    6000 of the wheelset and 5000 of the track)."""
    lag_zero: Literal["default", "residual", "wheel_residual", "printed", "zero", "folded"] = "default"
    """What a force displaces at its own instant; ``docs/validation.md`` compares them.

    ``causal``: ``residual`` (default) is the rail's static residual, ``wheel_residual`` adds the wheelset's, ``zero``
    has neither. ``paper``: ``printed`` (default) is the first rail value of Eq. (3), ``zero`` leaves it out, ``folded``
    folds what the band limit puts before t = 0 onto t > 0.
    """

    def __post_init__(self) -> None:
        check(self)
        for name, kinds, load in (("wheelset", AnyWheelset, "load_wheelset"), ("track", Track, "load_track")):
            if not isinstance(getattr(self, name), kinds):
                raise InputError(f"{name} = {getattr(self, name)!r} is a name, or plain data: give {load}({name})")
        if not self.name:
            raise InputError("name is empty: give the scenario a name")
        known = LAG_ZERO[self.dynamics]
        if self.lag_zero not in ("default", *known):
            raise InputError(
                f"lag_zero = {self.lag_zero} does not apply to {self.dynamics} dynamics: give {', '.join(known)}"
            )
        self._check_speeds()
        self._check_vehicle()
        _check_models(self.wheelset, self.track, self.loads, self.output.stress_nodes, self.step_length)
        self.loads.check_weight(self.wheelset, self.axle_load)
        slowest = min(self.speed, *(point.speed for point in self.speed_plan), math.inf) / self.step_length
        check_sensors(self.sensors, self.wheelset, self.dynamics, slowest)
        check_detectors(self.wayside, self.track, slowest, self.step_length)
        check_number(len(self.irregularities))
        around, along, dx = self.steps_per_revolution, self.line_steps, self.step_length
        _check_each(self.irregularities, around, along, dx)
        rolling_surfaces(self.irregularities, self.geometry, dx, around, along)
        if self.events:
            check_events(self)

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
    def steps_per_revolution(self) -> int:
        """Steps in one turn of the wheel."""
        return round(2 * math.pi * self.wheelset.rolling_radius / self.step_length)

    @property
    def tread_origin(self) -> int:
        """Step at which angle 0 of the treads meets the rail."""
        return round(self.reference_position / self.step_length)

    @property
    def settles_on_surfaces(self) -> bool:
        """Whether the wheels run on the irregularities of the scenario before step 0."""
        return self.settle_on == "surfaces" and self.dynamics == "causal"

    @property
    def all_irregularities(self) -> tuple[Irregularity, ...]:
        """Irregularities, and those that events bring."""
        return (*self.irregularities, *(item for event in self.events for item in event.brought))

    @property
    def geometry(self) -> ContactGeometry:
        """Wheels on rails, where they touch."""
        wheelset = self.wheelset
        return self.profiles.geometry(wheelset.rolling_radius, wheelset.rolling_circles, self.lateral_offset)

    @property
    def touched_wheelset(self) -> AnyWheelset:
        """The wheelset with its contact points where the profiles touch; an imported one has its own points."""
        if isinstance(self.wheelset, ImportedWheelset):
            return self.wheelset
        geometry = self.geometry
        shifts = (geometry.touch(0) - geometry.rolling_circle(0), geometry.touch(1) - geometry.rolling_circle(1))
        return replace(self.wheelset, contact_shifts=shifts)

    @property
    def at_lag_zero(self) -> str:
        """The variant at lag zero, the default named."""
        return LAG_ZERO[self.dynamics][0] if self.lag_zero == "default" else self.lag_zero

    def to_mapping(self) -> dict[str, Any]:
        """Plain mapping that ``scenario_from`` turns into an equal scenario; shipped models are names in it."""
        mapping: dict[str, Any] = plain(self)
        return mapping

    def to_yaml(self) -> str:
        """The scenario as a YAML file's text."""
        return self._yaml

    @cached_property
    def _yaml(self) -> str:
        return dump(self.to_mapping())  # in 2 ms: a run of many changes is told often

    @property
    def digest(self) -> str:
        """Digest of all that the scenario says; names of shipped models count as names."""
        return digest(self.to_mapping())

    def check_change(self, new: Scenario) -> None:
        """Raise InputError if ``new``, of the same models, cannot follow this one during a run."""
        if new.axle_load != self.axle_load and self.vehicle and self.vehicle.body_mass:
            raise InputError(
                "axle_load cannot change during a run with vehicle.body_mass, because the car body is that load: "
                "start a new run, or leave body_mass out"
            )
        self.loads.check_change(new.loads)
        if [each.silent for each in new.sensors] != [each.silent for each in self.sensors]:
            raise InputError("of sensors, only noise and drift can change during a run: start a new one for others")
        if new.speed != self.speed and self.dynamics == "paper":
            raise InputError(f"speed cannot change in {self.dynamics} dynamics: start a new run, or use causal")

    def _check_vehicle(self) -> None:
        if self.vehicle is None:
            return
        if not isinstance(self.vehicle, Vehicle):
            raise InputError(f"vehicle = {self.vehicle!r} is not a Vehicle: give load_vehicle(vehicle)")
        if self.vehicle.body_mass is not None and self.dynamics == "paper":
            raise InputError(
                "vehicle.body_mass moves too slowly for the Green's functions of paper dynamics: leave it out, "
                "or use causal"
            )
        primary_suspension(self.wheelset)

    def _check_speeds(self) -> None:
        for index, (before, after) in enumerate(pairwise(self.speed_plan)):
            if after.time <= before.time:
                raise InputError(
                    f"speed_plan.{index + 1}.time = {after.time:g} s is not after the {before.time:g} s of the set "
                    f"point before: give times that increase"
                )
        if self.speed_plan and self.dynamics == "paper":
            raise InputError("speed_plan cannot be followed in paper dynamics, whose speed is constant: use causal")
        if self.dynamics == "paper":
            band, half = self.max_frequency or PAPER_BAND, 0.5 / self.step_period
            if band > half:
                raise InputError(
                    f"max_frequency = {band:g} Hz is above half the sampling frequency of {2 * half:g} Hz at "
                    f"{self.speed:g} m/s: give up to {half:g} Hz"
                )
        if self.track.line is None:
            return
        if self.dynamics == "paper":
            raise InputError("track.line cannot be followed in paper dynamics, whose supports are equal: use causal")
        speeds = {"speed": self.speed} | {f"speed_plan.{n}.speed": at.speed for n, at in enumerate(self.speed_plan)}
        for key, speed in speeds.items():
            if self.step_length > LONGEST_STEP * speed * (1 + 1e-9):
                raise InputError(
                    f"{key} = {speed:g} m/s makes steps of {1e3 * self.step_length / speed:.3g} ms, and track.line "
                    f"holds up to {1e3 * LONGEST_STEP:g} ms: give {self.step_length / LONGEST_STEP:g} m/s or more, or "
                    f"a step_length up to {LONGEST_STEP * speed:g} m"
                )


@lru_cache(maxsize=8)
def _check_models(
    wheelset: AnyWheelset,
    track: Track,
    loads: Loads,
    stress_nodes: tuple[str, ...],
    dx: float,
) -> None:
    """Raise InputError for models, loads and stress nodes that do not fit each other."""
    bay = track.spacing / dx
    if not _whole(bay):
        raise InputError(
            f"step_length = {dx:g} m does not divide the sleeper spacing of {track.spacing:g} m: "
            f"give {dividing(track.spacing, math.ceil(bay))} m"
        )
    nodes = [node.name for node in wheelset.stress_nodes]
    for index, node in enumerate(stress_nodes):
        if node not in nodes:
            where = f"output.stress_nodes.{index} = {node!r}"
            raise InputError(unknown("stress node of this wheelset", where, node, nodes))
    loads.check_against(wheelset)
    track.check_step(dx)


@lru_cache(maxsize=8)
def _check_each(irregularities: tuple[Irregularity, ...], around: int, along: int, dx: float) -> None:
    """Raise InputError for the first irregularity that does not fit its surface."""
    for index, item in enumerate(irregularities):
        surface = Surface(item.on, around if item.on in WHEELS else along, dx)
        try:
            for patch in item.patches(surface, MIDDLE):
                check_length(item, patch, surface)
        except InputError as refusal:
            raise InputError(f"irregularities.{index}: {refusal}") from None


def _whole(count: float) -> bool:
    return abs(count - round(count)) <= 1e-6


def dividing(length: float, parts: int) -> str:
    """A length that goes ``parts`` times into ``length``, or a little more often: the first that few digits can say."""
    found = (f"{length / count:.6g}" for count in range(parts, 2 * parts + 1))
    return next((each for each in found if _whole(length / float(each))), f"{length / parts!r}")
