"""Detectors and their channels, as people give them.

A channel is on one rail, at ``x`` m from the detector's position in the running direction. What it reads is a sum of
readings of the rail or of a sleeper at places (``Term``), whose influence lines ``track.influence`` has.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, TypeAlias

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, parsed, plain, quantity, read, unknown
from ..track.influence import Quantity
from ..track.track import Track

Rail = Literal["rail_1", "rail_2"]
RAILS: tuple[Rail, Rail] = ("rail_1", "rail_2")
NAME = re.compile(r"[a-z](_?[a-z0-9])*")
LONGEST_NAME = 60
MOST = 64
"""Channels of a detector."""
ABOVE = 1e-3
"""Largest distance of a channel on a sleeper from its middle, m."""


class Term(NamedTuple):
    """Part of what a channel reads: a quantity at a place, times a factor and a power of ``i omega``."""

    quantity: Quantity
    x: float
    """m from the detector's position."""
    factor: float = 1.0
    order: int = 0
    """Of the rate."""


@dataclass(frozen=True)
class Gauge:
    """A gauge, or a bridge of gauges, on one rail or on a sleeper under it."""

    name: str
    on: Rail
    x: float = quantity("m", -100.0, 100.0, "the distance from the detector's position in the running direction")

    type: ClassVar[str]
    unit: ClassVar[str]
    on_sleeper: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check(self)
        _check_name(self.name, "channel")

    @property
    def rail(self) -> int:
        """0 of rail 1, 1 of rail 2."""
        return RAILS.index(self.on)

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        raise NotImplementedError


@dataclass(frozen=True)
class ShearBridge(Gauge):
    """Difference of the rail's shear force at two places: the vertical force between them."""

    length: float = quantity("m", 0.02, 10.0, "the distance between both pairs of gauges", default=0.3)

    type: ClassVar[str] = "shear_bridge"
    unit: ClassVar[str] = "N"

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return Term("shear", self.x - self.length / 2), Term("shear", self.x + self.length / 2, -1.0)


@dataclass(frozen=True)
class BendingStrain(Gauge):
    """Strain along the rail, positive in tension."""

    z: float = quantity("m", -0.2, 0.2, "the height above the rail's neutral axis", default=-0.08)

    type: ClassVar[str] = "bending_strain"
    unit: ClassVar[str] = ""

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return (Term("moment", self.x, self.z / track.rail.EI),)


@dataclass(frozen=True)
class RailDisplacement(Gauge):
    """Displacement of the rail, upwards."""

    type: ClassVar[str] = "rail_displacement"
    unit: ClassVar[str] = "m"

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return (Term("deflection", self.x, -1.0),)


@dataclass(frozen=True)
class RailAcceleration(Gauge):
    """Acceleration of the rail, upwards."""

    type: ClassVar[str] = "rail_acceleration"
    unit: ClassVar[str] = "m/s^2"

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return (Term("deflection", self.x, -1.0, 2),)


@dataclass(frozen=True)
class SeatForce(Gauge):
    """Force of the rail on its seat, positive in compression."""

    type: ClassVar[str] = "seat_force"
    unit: ClassVar[str] = "N"
    on_sleeper: ClassVar[bool] = True

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return (Term("seat_force", self.x),)


@dataclass(frozen=True)
class SleeperDisplacement(Gauge):
    """Displacement of the sleeper at the rail seat, upwards."""

    type: ClassVar[str] = "sleeper_displacement"
    unit: ClassVar[str] = "m"
    on_sleeper: ClassVar[bool] = True

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return (Term("sleeper_deflection", self.x, -1.0),)


@dataclass(frozen=True)
class SleeperAcceleration(Gauge):
    """Acceleration of the sleeper at the rail seat, upwards."""

    type: ClassVar[str] = "sleeper_acceleration"
    unit: ClassVar[str] = "m/s^2"
    on_sleeper: ClassVar[bool] = True

    def terms(self, track: Track) -> tuple[Term, ...]:
        """What it reads on a track."""
        return (Term("sleeper_deflection", self.x, -1.0, 2),)


Channel: TypeAlias = (
    ShearBridge
    | BendingStrain
    | RailDisplacement
    | RailAcceleration
    | SeatForce
    | SleeperDisplacement
    | SleeperAcceleration
)


@dataclass(frozen=True)
class Detector:
    """Channels beside the track that are sampled together while a wheelset passes.

    Examples
    --------
    >>> detector = load_detector("shear_array")
    >>> detector.channels[0].type, detector.channels[0].unit, f"{detector.band:g} Hz"
    ('shear_bridge', 'N', '2000 Hz')
    """

    name: str
    channels: tuple[Channel, ...]
    rate: float = quantity("Hz", 100.0, 1e5, "the sampling rate", default=1e4)
    band: float = quantity("Hz", 10.0, 1e4, "the band", default=2e3)
    """Of the low pass without delay through which all channels are read: flat to 80 % of it, nothing beyond."""
    reach: float = quantity("m", 0.0, 20.0, "the track before the first and behind the last channel", default=0.6)
    """Samples begin when the wheelset is that far before the first channel, and end as far behind the last."""

    def __post_init__(self) -> None:
        check(self)
        _check_name(self.name, "detector")
        if not self.channels:
            raise InputError("channels is empty: give at least one channel, such as {type: shear_bridge, ...}")
        if len(self.channels) > MOST:
            raise InputError(f"channels has {len(self.channels)} entries: give up to {MOST}")
        names = [channel.name for channel in self.channels]
        for index, name in enumerate(names):
            if name in names[:index]:
                raise InputError(f"channels.{index}.name = {name!r} is that of another channel: give another name")
        if self.band > self.rate / 2:
            raise InputError(
                f"band = {self.band:g} Hz is above half the rate of {self.rate:g} Hz: give up to {self.rate / 2:g} Hz, "
                f"or a higher rate"
            )

    def ends(self, track: Track) -> tuple[float, float]:
        """First and last place that is read, m from the detector's position."""
        places = [term.x for channel in self.channels for term in channel.terms(track)]
        return min(places), max(places)


def load_detector(source: str | Path) -> Detector:
    """Load a detector.

    Parameters
    ----------
    source
        Name of a shipped detector (``shear_single``, ``shear_array``, ``accelerometers``), or path of a YAML file.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.

    Examples
    --------
    >>> [channel.name for channel in load_detector("shear_single").channels]
    ['bay_1_rail_1', 'bay_1_rail_2']
    """
    return read_detector(shipped.load_yaml("detectors", source), "")


def read_detector(data: Any, where: str) -> Detector:
    """Detector from the name of a shipped one or from a mapping; ``where`` is the key that messages begin with.

    Raises InputError.
    """
    if isinstance(data, Detector):
        return data
    if isinstance(data, str):
        if data not in shipped.names("detectors"):
            raise InputError(unknown("detector", f"{where} = {data!r}", data, shipped.names("detectors")))
        return load_detector(data)
    return read(Detector, data, where)


def plain_detector(detector: Detector) -> Any:
    """Name of a shipped detector, or a mapping of all that it is; ``read_detector`` reads both."""
    if detector.name in shipped.names("detectors") and detector == load_detector(detector.name):
        return detector.name
    return plain(detector)


@dataclass(frozen=True)
class WaysideDetector:
    """A detector that stands beside the track."""

    detector: Detector = parsed(read_detector, plain_detector)
    """In files: the name of a shipped detector, the path of a file, or a mapping."""
    position: float = quantity("m", 0.0, 1e7, "the position of the detector along the track")
    name: str = ""
    """Last part of its topic; the name of the detector if empty."""

    def __post_init__(self) -> None:
        check(self)
        if self.name:
            _check_name(self.name, "topic")

    @property
    def topic(self) -> str:
        """Where it publishes."""
        return f"wayside/{self.name or self.detector.name}"


def check_detectors(standing: Sequence[WaysideDetector], track: Track, slowest: float, step_length: float) -> None:
    """Raise InputError, with the dotted key, for detectors that cannot stand where they do, or that share a topic.

    ``slowest`` is the least rate of the steps, Hz.
    """
    if len(standing) > MOST:
        raise InputError(f"wayside has {len(standing)} entries: give up to {MOST}")
    topics = [each.topic for each in standing]
    for index, each in enumerate(standing):
        if each.topic in topics[:index]:
            raise InputError(f"wayside.{index}: topic {each.topic} is that of another detector: give another name")
        try:
            check_place(each.detector, track, each.position, slowest)
        except InputError as refusal:
            raise InputError(f"wayside.{index}: {refusal}") from None
        first = each.detector.ends(track)[0] - each.detector.reach
        if each.position + first < -step_length:
            raise InputError(
                f"wayside.{index}.position = {each.position:g} m is off the line, which begins at 0 m: detector "
                f"{each.detector.name} reads from {each.position + first:.4g} m, give at least {-first:.4g} m"
            )


def check_place(detector: Detector, track: Track, position: float, step_rate: float) -> None:
    """Raise InputError for a detector that cannot stand at ``position`` m, where steps come at ``step_rate`` Hz."""
    if track.line is not None:
        raise InputError(
            f"detector {detector.name} reads a track whose supports are all the same, and track.line makes them "
            f"differ: leave out track.line, or the detector"
        )
    if detector.band > step_rate / 2 * (1 + 1e-9):
        raise InputError(
            f"band = {detector.band:g} Hz of detector {detector.name} is above half the {step_rate:.6g} steps a second "
            f"at the lowest speed: give up to {step_rate / 2:.6g} Hz, or a shorter step_length"
        )
    for index, channel in enumerate(detector.channels):
        if not channel.on_sleeper:
            continue
        if track.sleeper is None and channel.type != SeatForce.type:
            raise InputError(
                f"channels.{index} of detector {detector.name} is a {channel.type}, and slab track has no sleepers: "
                f"leave it out"
            )
        place = position + channel.x
        nearest = round(place / track.spacing) * track.spacing
        if abs(place - nearest) > ABOVE:
            raise InputError(
                f"channels.{index}.x = {channel.x:g} m puts a {channel.type} at {place:g} m, beside a sleeper: give "
                f"{nearest - position:.4g} m, or a position at a whole number of bays of {track.spacing:g} m"
            )


def _check_name(name: str, what: str) -> None:
    if not NAME.fullmatch(name) or len(name) > LONGEST_NAME:
        raise InputError(
            f"name = {name!r} cannot name a {what}: give at most {LONGEST_NAME} lower-case letters, digits and single "
            f"underscores between them, a letter first"
        )
