"""Parameters of the node: declared once from the package's own quantities, mapped to a scenario and a pace."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..bags.settings import RecordSettings
from ..errors import InputError
from ..fatigue.curve import load_curve
from ..inputs.schema import Quantity, quantity_of
from ..live.fatigue_watch import FatigueSettings
from ..live.pacing import Pace
from ..monitoring.limits import Limits
from ..samples.decimation import FACTOR
from ..samples.impacts import ImpactSettings
from ..scenario import Scenario, load_scenario
from ..scenario.values import SCENARIO_NUMBERS, Values, quantity_named, values_of, with_values
from ..verdict.limit_set import DEFAULT_LIMITS, load_limits
from .declaring import declare, described, fixed, number, warn_of_unknown, whole

T = TypeVar("T")

START_UP = {
    "scenario": ("damage_wheel_1", "Name of a shipped scenario, or path of a scenario file"),
    "autostart": (True, "Configure and activate at the start, without a lifecycle manager"),
    "profiles.directory": ("profiles", "Folder of the files that irregularities may name over ROS"),
    "record.directory": ("recordings", "Folder in which bags are written"),
    "record.name": ("", "Name of the bag in record.directory; empty: made from date and time"),
    "record.on_start": (False, "Record from the start of the run on"),
    "frame_prefix": ("", "Prefix of frame_id; empty: the name of the node, and none if that is wheelset_track_sim"),
    "publish_odometry": (False, "Publish the position of the wheelset on odometry, once a chunk; needs nav_msgs"),
    "publish_tf": (False, "Publish the transforms map, track, wheelset on /tf and /tf_static; needs tf2_msgs"),
    "publish_clock": (False, "Publish the time of the run on /clock, for nodes with use_sim_time"),
    "fatigue.curve": (
        "",
        "S-N curve for fatigue: a shipped name or a file; empty: fatigue is not counted",
    ),
    "fatigue.axle": ("", "Identity of the axle in ledgers; empty: the name of the node"),
    "fatigue.ledger": ("", "File in which fatigue is kept; empty: only where save_fatigue puts it"),
    "limits": (DEFAULT_LIMITS, "Limits for the verdict in diagnostics: name of a shipped set, path of a file, or none"),
    "prometheus.address": ("127.0.0.1", "Address on which metrics are served; 0.0.0.0 is all of this machine"),
}
COUNTED = ("angles", "mark", "checkpoint")
"""Numbers of how fatigue is counted."""
PORT = Quantity("", 0, 65535, "the port on which metrics are served, 0 for none,")
WATCHED = {"impact": ImpactSettings, "diagnostics": Limits}
"""What is watched, by the first part of the names of its parameters."""
MODE = "continuous records everything; snapshot records the time around impacts, and on request"
DECIMATED = ("contact_forces", "axle_stress")
"""Topics that may be decimated."""


@dataclass(frozen=True)
class Watching:
    """What is worth telling."""

    impact: ImpactSettings
    limits: Limits


class Parameters:
    """The parameters that a node declares, and what they describe."""

    def __init__(self, node: Node) -> None:
        """Declare all parameters of ``node``; raises InputError if one given at the start cannot be used."""
        self._node = node
        self.following = False
        """Whether parameters are being set to what another way has changed already."""
        for name, (default, description) in START_UP.items():
            declare(node, name, default, fixed(description))
        self.file = load_scenario(self["scenario"])
        """The scenario without parameters."""
        self._listed = self.file.irregularities  # of which the parameters show the first of each wheel
        for name, value in values_of(self.file).items():
            declare(node, name, value, number(quantity_named(name)))
        for field in dataclasses.fields(Pace):
            quantity = quantity_of(Pace, field.name)
            declare(node, field.name, field.default, number(quantity, read_only=field.name == "duration"))
        for topic in DECIMATED:
            declare(
                node, f"{topic}.decimation", 1, whole(FACTOR, f"Steps from sample to sample of {topic}: 1 is full rate")
            )
        for prefix, kind in WATCHED.items():
            for field in dataclasses.fields(kind):
                declare(node, f"{prefix}.{field.name}", field.default, number(quantity_of(kind, field.name)))
        for field in dataclasses.fields(RecordSettings):
            declare(node, f"record.{field.name}", field.default, _of_recording(field.name, field.default))
        for name in COUNTED:
            of = quantity_of(FatigueSettings, name)
            descriptor = whole(of, described(of), read_only=True) if name == "angles" else number(of, read_only=True)
            declare(node, f"fatigue.{name}", FatigueSettings.__dataclass_fields__[name].default, descriptor)
        declare(node, "prometheus.port", 0, whole(PORT, PORT.meaning.rstrip(","), read_only=True))
        warn_of_unknown(node)
        load_limits(self["limits"])
        self.fatigue()
        self.check_clock(self["use_sim_time"])
        self.changed({}, self.file)
        self.pace({})
        self.watching({})
        self.recording({})

    def __getitem__(self, name: str) -> Any:
        """Value of a parameter."""
        return self._node.get_parameter(name).value

    def changed(self, changes: Values, scenario: Scenario) -> Scenario:
        """``scenario`` with the parameters and ``changes`` of them; raises InputError that names the parameter.

        A speed among the changes ends its speed plan, also if it is the one that the plan begins with.
        """
        values = {name: self[name] for name in values_of(self.file)} | dict(changes)
        plan = () if "speed" in changes else scenario.speed_plan
        return with_values(dataclasses.replace(scenario, irregularities=self._listed, speed_plan=plan), values)

    def follow(self, scenario: Scenario) -> None:
        """Show a scenario that was set by other means than parameters.

        Those of damage show the first breakout of each wheel; a parameter that is set replaces it, the further stay.
        """
        shown = values_of(scenario)
        if self.changed({}, scenario).irregularities == scenario.irregularities:
            shown = {name: shown[name] for name in SCENARIO_NUMBERS}
        else:
            self._listed = scenario.irregularities
        self.following = True
        try:
            different = [Parameter(name, value=value) for name, value in shown.items() if self[name] != value]
            self._node.set_parameters_atomically(different)
        finally:
            self.following = False

    def check_clock(self, use_sim_time: bool) -> None:
        """Raises InputError if the node cannot have its time on ``/clock``."""
        if use_sim_time and self["publish_clock"]:
            raise InputError(
                "use_sim_time and publish_clock cannot both be true: "
                "a node cannot follow the clock that it publishes, set one of them to false"
            )

    def pace(self, changes: Values) -> Pace:
        """Pace with ``changes`` made; raises InputError that names the parameter."""
        values = {field.name: self[field.name] for field in dataclasses.fields(Pace)} | dict(changes)
        return Pace(**{field.name: values[field.name] for field in dataclasses.fields(Pace)})

    def watching(self, changes: Values) -> Watching:
        """What is worth telling with ``changes`` made, all checked; raises InputError that names the parameter."""
        return Watching(*(self._made(prefix, kind, changes) for prefix, kind in WATCHED.items()))

    def recording(self, changes: Values) -> RecordSettings:
        """How recordings are made that begin with ``changes`` made; raises InputError that names the parameter."""
        return self._made("record", RecordSettings, changes)

    def fatigue(self) -> FatigueSettings | None:
        """How fatigue is counted, or None; raises InputError that names the parameter."""
        if not self["fatigue.curve"]:
            return None
        curve = load_curve(self["fatigue.curve"])
        axle = self["fatigue.axle"] or self._node.get_fully_qualified_name()
        ledger = Path(self["fatigue.ledger"]).expanduser() if self["fatigue.ledger"] else None
        try:
            return FatigueSettings(curve, axle, ledger=ledger, **{name: self[f"fatigue.{name}"] for name in COUNTED})
        except InputError as refusal:
            raise InputError(f"fatigue.{refusal}") from None

    def decimation(self, changes: Values) -> dict[str, int]:
        """Steps from sample to sample of each topic in ``DECIMATED`` with ``changes`` made."""
        names = {topic: f"{topic}.decimation" for topic in DECIMATED}
        return {topic: changes[name] if name in changes else self[name] for topic, name in names.items()}

    def _made(self, prefix: str, kind: type[T], changes: Values) -> T:
        names = {name: f"{prefix}.{name}" for name in kind.__dataclass_fields__}  # type: ignore[attr-defined]
        try:
            return kind(**{key: changes.get(name, self[name]) for key, name in names.items()})
        except InputError as refusal:
            raise InputError(f"{prefix}.{refusal}") from None


def _of_recording(name: str, default: Any) -> ParameterDescriptor:
    if name == "mode":
        return ParameterDescriptor(description=MODE)
    quantity = quantity_of(RecordSettings, name)
    return whole(quantity, described(quantity)) if isinstance(default, int) else number(quantity)
