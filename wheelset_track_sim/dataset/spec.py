"""What a data set is to hold: a YAML file, checked whole before anything is simulated."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, confirmed_numbers, keyed, parsed, plain, quantity, read, value_as
from ..scenario import Scenario, assign, find_beside, load_scenario, scenario_from, suspect, take_in
from ..sensors.kinds import Sensor
from ..studies.distributions import Distribution
from ..wayside.detector import Detector, check_place, plain_detector, read_detector
from .damage import BreakoutDamage, DamageKind, FlatDamage, NoDamage, WornFlatDamage
from .drawn import Drawn, drawn, highest, lowest

FORCES = "contact_force"
"""Array of the contact forces, beside those of the sensors."""


@dataclass(frozen=True)
class JointDraws:
    """Joints of the rails: both rails have one at the same place, or none."""

    share: float = quantity("", 0.0, 1.0, "the share of sites with a joint", default=0.5)
    dip_angle: Drawn = drawn(
        "rad", 0.0, 0.04, "the angle between the rail ends", default=Distribution("uniform", low=0.002, high=0.012)
    )
    gap: float = quantity("m", 0.0, 0.020, "the width of the gap", default=0.006)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Split:
    """Shares of the trains, and so of the wheelsets, in each part of the data set."""

    train: float = quantity("", 0.0, 1.0, "the share for training", default=0.7)
    validation: float = quantity("", 0.0, 1.0, "the share for validation", default=0.15)
    test: float = quantity("", 0.0, 1.0, "the share for tests", default=0.15)

    def __post_init__(self) -> None:
        check(self)
        if not math.isclose(self.train + self.validation + self.test, 1.0, abs_tol=1e-9):
            found = self.train + self.validation + self.test
            raise InputError(f"train + validation + test = {found:g}: give shares that add up to 1")


@dataclass(frozen=True)
class DatasetSpec:
    """A data set: what is drawn, what is measured, and how it is split.

    A train has some wheelsets with the same roughness of the treads, each with its own damage. In each passage it has
    one speed and load, and passes a site: a track with supports that scatter, rough rails, and maybe a joint.
    ``docs/howto/dataset.md`` describes the keys.
    """

    title: str
    licence: str
    """Under which the data set may be used, such as ``CC-BY-4.0``."""
    description: str = ""
    scenario: Any = "undamaged"
    """Name of a shipped scenario, path of a file, or a mapping: wheelset, track and all that is not drawn."""
    set: Any = field(default_factory=dict)
    """Dotted scenario keys that differ from it."""
    speed: Drawn = drawn(
        "m/s",
        5.0,
        100.0,
        "the running speed",
        default=Distribution("normal", mean=25.0, deviation=4.0, low=50 / 3, high=100 / 3),
    )
    axle_load: Drawn = drawn("N", 2e4, 4e5, "the axle load", default=Distribution("uniform", low=9.81e4, high=2.1582e5))
    damage: tuple[DamageKind, ...] = (NoDamage(3.0), FlatDamage(), WornFlatDamage(), BreakoutDamage())
    wheel_roughness: Drawn | None = drawn(
        "dB",
        -40.0,
        20.0,
        "the level of the treads' roughness above the limit of ISO 3095",
        default=Distribution("normal", mean=-3.0, deviation=3.0, low=-10.0, high=6.0),
        optional=True,
    )
    rail_roughness: Drawn | None = drawn(
        "dB",
        -40.0,
        20.0,
        "the level of the rails' roughness above the limit of ISO 3095",
        default=Distribution("normal", mean=-3.0, deviation=3.0, low=-10.0, high=6.0),
        optional=True,
    )
    pad_scatter: Drawn = drawn("", 0.0, 1.0, "the coefficient of variation of the pads' stiffness", default=0.15)
    ballast_scatter: Drawn = drawn("", 0.0, 1.0, "the same of the ballast", default=0.3)
    joint: JointDraws = field(default_factory=JointDraws)
    rate: float = quantity("Hz", 100.0, 1e6, "the sampling rate of all signals", default=1e4)
    duration: float = quantity("s", 0.01, 60.0, "the length of a sample", default=0.25)
    sensors: tuple[Sensor, ...] = parsed(
        lambda data, where: data,  # read when the rate is known
        plain,
        default=(
            {"type": "axle_box_acceleration", "range": 2000.0, "noise": 2.0},
            {"type": "strain_gauge", "name": "middle", "y": 0.0, "range": 2e-3, "noise": 1e-6},
        ),
    )
    """As in a scenario; without ``rate`` they have that of the data set."""
    detector: Detector | None = parsed(
        lambda data, where: None if data is None else read_detector(data, where),
        lambda detector: None if detector is None else plain_detector(detector),
        default=None,
    )
    """Beside the track, with the bays of the site but without their scatter; a shipped one by name, or a mapping."""
    detector_noise: float = quantity(
        "", 0.0, 1.0, "the standard deviation of its noise, as a share of the largest value of a channel", default=0.01
    )
    wheelsets: int = quantity("", 1, 256, "the number of wheelsets of a train", default=16)
    passages: int = quantity("", 1, 256, "the number of passages of each train", default=2)
    split: Split = field(default_factory=Split)

    def __post_init__(self) -> None:
        check(self)
        keyed(self.set, "set")
        for name in ("title", "licence"):
            if not getattr(self, name).strip():
                raise InputError(f"{name} is empty: give the {name} of the data set")
        if not isinstance(self.scenario, (str, Path, Mapping)):
            raise InputError(f"scenario = {self.scenario!r} is neither a name, nor a file, nor a mapping of its keys")
        if not sum(kind.weight for kind in self.damage) > 0:
            raise InputError("damage has no kind with a weight above 0: give at least one, such as {type: flat}")
        object.__setattr__(self, "sensors", self._sensors(self.sensors))
        base = self.base  # read now, so that a data set that exists can be written
        for name, value in (
            ("speed_plan", base.speed_plan),
            ("events", base.events),
            ("track.line", base.track.line),
            ("wayside", base.wayside),
        ):
            if value:
                raise InputError(f"scenario.{name} has no place in a data set: leave it out")
        if base.dynamics != "causal":
            raise InputError(f"scenario.dynamics = {base.dynamics} has no place in a data set: give causal")
        turn = 2 * math.pi * base.wheelset.rolling_radius
        if 2 * max(kind.half_length for kind in self.damage) > turn / 4:
            raise InputError(f"damage reaches over a quarter of the tread's {turn:.3g} m: give shorter ones")
        if self.duration * lowest(self.speed) < turn:
            raise InputError(
                f"duration = {self.duration:g} s at {lowest(self.speed):g} m/s is less than a turn of {turn:.3g} m, so "
                f"that damage may not meet the rail: give {turn / lowest(self.speed):.3g} s or more, or higher speeds"
            )

        if self.detector is not None:
            self._check_detector(self.detector, base)

    def _check_detector(self, detector: Detector, base: Scenario) -> None:
        """Raise InputError for a detector that does not fit the track, or that a sample does not pass as a whole."""
        spacing, slowest = base.track.spacing, lowest(self.speed)
        check_place(detector, base.track, spacing * 100, slowest / base.step_length)
        needed = self.detector_track + 2 * spacing
        if self.duration * slowest < needed:
            raise InputError(
                f"duration = {self.duration:g} s at {slowest:g} m/s is {self.duration * slowest:.3g} m, and detector "
                f"{detector.name} needs {needed:.3g} m: give {needed / slowest:.3g} s or more, or a shorter detector"
            )

    @property
    def detector_track(self) -> float:
        """Track over which the detector reads, m; 0 without one."""
        if self.detector is None:
            return 0.0
        first, last = self.detector.ends(self.base.track)
        return last - first + 2 * self.detector.reach

    @property
    def detector_samples(self) -> int:
        """Values of a channel of the detector at the lowest speed; at higher ones the last are NaN."""
        rate = self.detector.rate if self.detector else 0.0
        return math.ceil(self.detector_track / lowest(self.speed) * rate) + 2

    def _sensors(self, given: Any) -> tuple[Sensor, ...]:
        """Sensors at the rate of the data set, from plain data or themselves; raises InputError."""
        if isinstance(given, (list, tuple)):
            given = [({"rate": self.rate} | dict(each)) if isinstance(each, Mapping) else each for each in given]
        found: tuple[Sensor, ...] = value_as(tuple[Sensor, ...], given, "sensors")
        for index, sensor in enumerate(found):
            if sensor.rate != self.rate:
                raise InputError(
                    f"sensors.{index}.rate = {sensor.rate:g} Hz is not the rate of the data set, {self.rate:g} Hz: "
                    "leave it out"
                )
        return tuple(replace(each, seed=0, true_value=False) for each in found)

    @cached_property
    def base(self) -> Scenario:
        """Scenario with all that is not drawn, at the lowest speed and the highest load; raises InputError."""
        named = self.scenario
        data = (scenario_from(named) if isinstance(named, Mapping) else load_scenario(named)).to_mapping()
        for key, value in self.set.items():
            suspect(key, value, f"set.{key}")
            assign(data, key, copy.deepcopy(value), "set.")
        take_in(data)
        with confirmed_numbers():
            base = scenario_from(data)
        return replace(
            base, name="dataset", sensors=self.sensors, speed=lowest(self.speed), axle_load=highest(self.axle_load)
        )

    @property
    def samples(self) -> int:
        """Values of a signal."""
        return round(self.duration * self.rate)

    @property
    def per_train(self) -> int:
        """Samples of all passages of a train."""
        return self.wheelsets * self.passages


def load_spec(name_or_path: str | Path) -> DatasetSpec:
    """Load the specification of a data set.

    Parameters
    ----------
    name_or_path
        Name of a shipped one (``damaged_wheels``), or path of a YAML file. Its ``scenario`` may be a file beside it.

    Raises
    ------
    InputError
        In one line, for anything that cannot be used.
    """
    try:
        data = shipped.load_yaml("datasets", name_or_path)
        if isinstance(data, dict) and Path(name_or_path).is_file():
            find_beside(data, "scenario", Path(name_or_path).parent)
        return read(DatasetSpec, data, "")
    except InputError as refusal:
        if str(name_or_path) in str(refusal):
            raise
        raise InputError(f"dataset {name_or_path}: {refusal}") from None
