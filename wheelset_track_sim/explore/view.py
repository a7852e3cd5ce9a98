"""What the controls of the page say, as text in an address and as a scenario that can be simulated."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args, get_type_hints
from urllib.parse import urlencode

from ..errors import InputError
from ..inputs import shipped
from ..inputs.amounts import amount
from ..inputs.schema import unknown
from ..irregularities import Irregularity
from ..irregularities.breakout import Breakout
from ..irregularities.flat import Flat
from ..irregularities.polygon import Harmonic, Polygon
from ..irregularities.roughness import Roughness
from ..scenario import WHEELS, Scenario
from ..scenario.scenario import Wheel
from ..track.track import load_track
from ..verdict.limit_set import DEFAULT_LIMITS, NO_LIMITS
from ..wheelset.around import NEARLY_NONE
from ..wheelset.imported import ImportedNode
from ..wheelset.kinds import load_wheelset
from ..wheelset.stress_node import StressNode

Kind = Literal["none", "breakout", "flat", "worn_flat", "polygon"]
Stress = Literal["turning", "fixed"]


class Slider(NamedTuple):
    """A number of the page, in the unit that it is shown in."""

    label: str
    unit: str
    low: float
    high: float
    step: float
    meaning: str
    si: str = "m"
    """SI unit of the value in a ``View``."""
    kinds: tuple[Kind, ...] = ()
    """Kinds of damage that have it; empty for all."""

    def shown(self, value: float) -> str:
        """Text of a value in SI."""
        size = amount(f"1 {self.unit}", self.si, self.label) if self.si else 1.0
        return f"{value / size:.7g}"

    def read(self, name: str, text: str) -> float:
        """Value in SI of a text; raises InputError for what is no number within the limits."""
        try:
            number = float(text)
        except ValueError:
            raise InputError(f"{name} = {text!r} is not a number: give the {self.label} in {self.unit}") from None
        if not self.low <= number <= self.high:  # nor NaN
            raise InputError(
                f"{name} = {number:g} {self.unit}".rstrip()
                + f" is out of range: give the {self.label} from {self.low:g} to {self.high:g} {self.unit}".rstrip()
            )
        return amount(f"{text.strip()} {self.unit}", self.si, name) if self.si else number


SLIDERS = {
    "length": Slider("length", "mm", 4, 200, 1, "Extent of the breakout along the tread.", kinds=("breakout",)),
    "width": Slider("width", "mm", 4, 100, 1, "Extent of the breakout across the tread.", kinds=("breakout",)),
    "depth": Slider("depth", "mm", 0, 5, 0.1, "Depth of the breakout at its centre.", kinds=("breakout",)),
    "flat": Slider(
        *("flat length", "mm", 5, 150, 1, "Length of the flat when it was fresh; it decides the depth."),
        kinds=("flat", "worn_flat"),
    ),
    "worn": Slider(
        *("worn length", "mm", 5, 500, 5, "Length over which rolling has rounded the flat; at least the flat length."),
        kinds=("worn_flat",),
    ),
    "order": Slider("waves", "", 1, 40, 1, "Number of waves around the wheel.", "", kinds=("polygon",)),
    "amplitude": Slider(
        "amplitude", "mm", 0, 0.5, 0.01, "Half the height of the waves, crest to trough.", kinds=("polygon",)
    ),
    "place": Slider(
        *(
            "place on bay",
            "mm",
            0,
            650,
            10,
            "Where the damage meets the rail, from a sleeper on; a bay is 0.6 or 0.65 m.",
        ),
        kinds=("breakout", "flat", "worn_flat"),
    ),
    "speed": Slider("speed", "km/h", 18, 360, 1, "Running speed.", "m/s"),
    "load": Slider("axle load", "t", 3, 40, 0.1, "Static load on both wheels together; 1 t is 9.81 kN.", "N"),
    "level": Slider("level", "dB", -20, 20, 1, "Third-octave level of the roughness above the limit.", ""),
}
"""Numbers of the page. The limits are those of scenarios or narrower: what can be drawn and answered at once."""
KINDS = {
    "none": "no damage",
    "breakout": "breakout",
    "flat": "fresh flat",
    "worn_flat": "rounded flat",
    "polygon": "polygon",
}
STRESSES = {"turning": "point that turns", "fixed": "top of the axle"}
MEANINGS = {
    "kind": "Shape of the damage. A breakout is a hollow (Eq. 22 of the paper), a fresh flat a chord with sharp edges.",
    "on": "Damaged wheel. Wheel 1 is far from the gearbox, wheel 2 next to it.",
    "wheelset": "Shipped wheelset, or that of the scenario. Another one needs new models: some seconds the first time.",
    "track": "Shipped track, or that of the scenario. Another one needs new models: some seconds the first time.",
    "rough": "Roughness of both treads, from 5 to 500 mm, relative to the limit of ISO 3095:2013 for rails.",
    "limits": "Limits that the verdict compares with: Sweden, the USA, Great Britain, an example of your own, or none.",
    "stress": "Axial stress at each stress node: of the point around the axle that has the largest range as the axle "
    "turns, or of the top of the axle, which does not turn.",
}
"""What the other controls mean."""


@dataclass(frozen=True)
class View:
    """Values of all controls, SI units.

    Examples
    --------
    >>> view = View.read({"kind": "flat", "flat": "60", "speed": "100"})
    >>> view.flat, view.query()
    (0.06, 'kind=flat&on=wheel_1&flat=60&place=0&speed=100&load=20&...&stress=turning')
    """

    kind: Kind = "breakout"
    on: Wheel = "wheel_1"
    length: float = 0.060
    width: float = 0.048
    depth: float = 0.002
    flat: float = 0.060
    worn: float = 0.120
    order: float = 6.0
    amplitude: float = 1e-4
    place: float = 0.0
    speed: float = 100 / 3.6
    load: float = 196200.0
    wheelset: str = "x40"
    track: str = "ballasted_60e1"
    rough: bool = False
    level: float = 0.0
    limits: str = DEFAULT_LIMITS
    stress: Stress = "turning"

    def query(self) -> str:
        """Text of an address that ``read`` reads: what applies, in the units of the page."""
        return urlencode({name: value for name, value in self.shown().items() if self.applies(name)})

    def shown(self) -> dict[str, str]:
        """Text of each control."""
        found = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, bool):
                found[field.name] = str(int(value))
            else:
                found[field.name] = SLIDERS[field.name].shown(value) if field.name in SLIDERS else value
        return found

    def applies(self, name: str) -> bool:
        """Whether a control has an effect, given the others."""
        if name == "level":
            return self.rough
        if name == "on":
            return self.kind != "none"
        return name not in SLIDERS or self.kind in (SLIDERS[name].kinds or KINDS)

    @classmethod
    def read(cls, given: Mapping[str, str], base: View | None = None) -> View:
        """View of texts by control, as in an address; those of ``base`` for what is not given.

        Raises InputError in one line, for a name or value that cannot be used.
        """
        values: dict[str, Any] = {}
        hints = get_type_hints(cls)
        for name, text in given.items():
            if name not in hints:
                raise InputError(unknown("control", name, name, [*hints]))
            if name in SLIDERS:
                values[name] = SLIDERS[name].read(name, text)
            elif hints[name] is bool:
                if text not in ("0", "1"):
                    raise InputError(f"{name} = {text!r} is not a switch: give 0 or 1")
                values[name] = text == "1"
            else:
                choices = get_args(hints[name])
                if choices and text not in choices:
                    raise InputError(unknown("choice", f"{name} = {text!r}", text, choices))
                values[name] = text
        return dataclasses.replace(base or cls(), **values)


@dataclass(frozen=True, eq=False)
class Base:
    """The scenario that a page begins with: all that the controls do not say is its."""

    scenario: Scenario
    """Without the damage that the controls took over, without sensors, speed plan and events."""
    begin: View
    notes: tuple[str, ...] = ()
    """What of the scenario a passage leaves out, in words."""

    @classmethod
    def of(cls, scenario: Scenario) -> Base:
        """Of a scenario, whose first breakout, flat or polygon goes to the controls; InputError for a slow one."""
        if scenario.dynamics != "causal":
            raise InputError(f"dynamics = {scenario.dynamics} is too slow to explore: give --set dynamics=causal")
        if scenario.output.stress_nodes == ():
            raise InputError("output.stress_nodes is empty, and the page shows stresses: name one at least")
        rest = [*scenario.irregularities]
        damage: dict[str, Any] = {"kind": "none"}
        for item in scenario.irregularities:
            found = _controls(item, scenario)
            if found is not None:
                rest.remove(item)
                damage = found
                break
        begin = View(
            **damage,
            speed=scenario.speed,
            load=scenario.axle_load,
            wheelset=scenario.wheelset.name,
            track=scenario.track.name,
        )
        begin = View.read(begin.shown())  # what is out of the range of a control is refused, with its name
        left_out = [name for name in ("speed_plan", "events", "sensors") if getattr(scenario, name)]
        kept = dataclasses.replace(
            scenario, irregularities=tuple(rest), speed_plan=(), events=(), sensors=(), settle_on="surfaces"
        )
        notes: tuple[str, ...] = (f"left out here: {', '.join(left_out)} of {scenario.name}",) if left_out else ()
        if rest:
            notes += (f"as in {scenario.name}, beside the damage: {', '.join(f'{x.type} on {x.on}' for x in rest)}",)
        return cls(kept, begin, notes)

    @property
    def wheelsets(self) -> list[str]:
        """Names that the control offers."""
        return _with_own(shipped.names("wheelsets"), self.scenario.wheelset.name)

    @property
    def tracks(self) -> list[str]:
        """Likewise."""
        return _with_own(shipped.names("tracks"), self.scenario.track.name)

    @property
    def limits(self) -> list[str]:
        """Likewise."""
        return [*shipped.names("limits"), NO_LIMITS]

    def surroundings(self, view: View) -> Scenario:
        """The scenario of a view without its damage: what runs on what, how rough; raises InputError."""
        own = self.scenario
        changes: dict[str, Any] = {}
        if view.wheelset != own.wheelset.name:
            _check_name("wheelset", view.wheelset, self.wheelsets)
            changes["wheelset"] = wheelset = load_wheelset(view.wheelset)
            nodes = tuple(node.name for node in wheelset.stress_nodes if _at_top(node))
            changes["output"] = dataclasses.replace(own.output, stress_nodes=nodes)
        if view.track != own.track.name:
            _check_name("track", view.track, self.tracks)
            changes["track"] = load_track(view.track)
        _check_name("limits", view.limits, self.limits)
        surfaces = own.irregularities
        if view.rough:
            surfaces += tuple(Roughness(on, seed=n, level=view.level) for n, on in enumerate(WHEELS, 1))
        if view.kind == "polygon":
            surfaces += (Polygon(view.on, (Harmonic(round(view.order), view.amplitude),)),)
        return dataclasses.replace(own, speed=view.speed, axle_load=view.load, irregularities=surfaces, **changes)

    def damage(self, view: View, scenario: Scenario) -> tuple[Irregularity, ...]:
        """The damage of a view that passes the rail on ``scenario`` once; a polygon is none. Raises InputError."""
        if view.kind in ("none", "polygon"):
            return ()
        dx, turn = scenario.step_length, scenario.steps_per_revolution
        ahead = round(view.place / dx) - scenario.tread_origin % round(scenario.track.spacing / dx)
        angle = ahead / turn * 2 * math.pi
        if view.kind == "breakout":
            return (Breakout(view.on, a=view.length / 2, b=view.width / 2, h=view.depth, angle=angle),)
        return (Flat(view.on, view.flat, view.worn if view.kind == "worn_flat" else None, angle),)

    def scenario_of(self, view: View) -> Scenario:
        """The whole scenario of a view, as a file has it; raises InputError.

        Where nothing but the damage is irregular, the damage meets the rail for the first time after step 0, as in the
        answer: one turn of a ``run`` has the same peaks. Rough treads need a run that settles on them.
        """
        around = self.surroundings(view)
        whole = (*around.irregularities, *self.damage(view, around))
        settle_on: Literal["surfaces", "smooth"] = "surfaces" if around.irregularities else "smooth"
        name = self.scenario.name if view == self.begin else f"{self.scenario.name}, explored"
        return dataclasses.replace(around, name=name, irregularities=whole, settle_on=settle_on)


def _controls(item: Irregularity, scenario: Scenario) -> dict[str, Any] | None:
    """Controls of an irregularity; None if there are none for it."""
    bay, around = scenario.track.spacing, scenario.steps_per_revolution * scenario.step_length
    if isinstance(item, Polygon) and len(item.harmonics) == 1 and item.harmonics[0].phase == 0.0:
        wave = item.harmonics[0]
        return {"kind": "polygon", "on": item.on, "order": float(wave.order), "amplitude": wave.amplitude}
    if not isinstance(item, (Breakout, Flat)) or (isinstance(item, Breakout) and item.y != 0.0):
        return None
    dx = scenario.step_length
    place = round((scenario.reference_position + item.angle / (2 * math.pi) * around) / dx) % round(bay / dx) * dx
    if isinstance(item, Breakout):
        size = {"kind": "breakout", "length": 2 * item.a, "width": 2 * item.b, "depth": item.h}
    elif item.worn_length is None:
        size = {"kind": "flat", "flat": item.length}
    else:
        size = {"kind": "worn_flat", "flat": item.length, "worn": item.worn_length}
    return size | {"on": item.on, "place": place}


def _at_top(node: StressNode | ImportedNode) -> bool:
    """Whether a stress node shows bending in the vertical plane."""
    if isinstance(node, ImportedNode):
        return abs(node.position[2]) > NEARLY_NONE * math.hypot(node.position[0], node.position[2])
    return abs(math.cos(node.angle)) > NEARLY_NONE


def _check_name(what: str, name: str, known: list[str]) -> None:
    if name not in known:
        raise InputError(unknown(what, f"{what} = {name!r}", name, known))


def _with_own(names: list[str], own: str) -> list[str]:
    return names if own in names else [own, *names]
