"""Parts of a wheelset and the checks of each: axle, wheels, brake discs, gearbox, axle boxes, material.

``y`` is the axial coordinate, 0 at the track's centre, positive to the left in the running direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import acos, sin, sqrt

from ..errors import InputError
from ..inputs.schema import check, quantity

LEAST_BOX = 1.0
"""Mass of an axle box that moves by itself, kg."""
SOFTEST_BEARING = 10.0
"""Of the stiffness of the suspension: a softer bearing would be a suspension itself."""
THICKEST_BORE = 0.8
"""Of the diameter of a section: a thinner wall is no axle any more."""


class Checked:
    """Checks the numbers of a dataclass against their declared limits when an instance is made."""

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class AxleSection(Checked):
    """Cylinder of the axle from the end of the section before it; a fillet leads over to the next one.

    The fillet lies on the thinner of the two sections, tangent to it, and meets the thicker one at its edge.
    """

    name: str
    end: float = quantity("m", -2.0, 2.0, "the y at which the section ends")
    diameter: float = quantity("m", 0.05, 0.4, "the diameter of the section")
    fillet: float = quantity("m", 1e-3, 0.2, "the radius of the fillet at the end of the section", default=0.04)


@dataclass(frozen=True)
class Step:
    """Change of diameter at the end of a section: the fillet covers ``length`` in y on the thinner section."""

    after: str
    edge: float
    """y of the thicker section's edge, m."""
    direction: int
    """+1 if the thinner section is at larger y."""
    low: float
    high: float
    """Radii of the thinner and the thicker section, m."""
    fillet: float
    """Radius of the fillet, m."""

    @property
    def angle(self) -> float:
        """Angle of the fillet's arc, rad."""
        return acos(1.0 - (self.high - self.low) / self.fillet)

    @property
    def tangent(self) -> float:
        """Where the fillet runs into the thinner section: y, m."""
        return self.edge + self.direction * self.fillet * sin(self.angle)


@dataclass(frozen=True)
class Axle(Checked):
    """Stepped axle, solid or bored along its whole length: sections in order of y."""

    start: float = quantity("m", -2.0, 0.0, "the y at which the first section starts")
    sections: tuple[AxleSection, ...] = ()
    bore: float = quantity("m", 0.0, 0.3, "the diameter of the bore along the axle", default=0.0)
    """0 is a solid axle."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.sections:
            raise InputError("axle.sections is empty: give at least one section")
        names = [section.name for section in self.sections]
        if len(set(names)) < len(names):
            raise InputError(f"axle.sections has names {', '.join(names)}: give each a name of its own")
        ends = [self.start, *(section.end for section in self.sections)]
        for name, (low, high) in zip(names, pairwise(ends), strict=True):
            if high <= low:
                raise InputError(
                    f"axle section {name} ends at y = {high:g} m, before it starts: give sections in order of y"
                )
        for section in self.sections:
            if self.bore > THICKEST_BORE * section.diameter:
                raise InputError(
                    f"axle.bore = {self.bore:g} m leaves too thin a wall of axle section {section.name}: give at most "
                    f"{THICKEST_BORE:g} of its diameter, {THICKEST_BORE * section.diameter:g} m"
                )
        for step in self.steps():
            if step.high - step.low >= step.fillet:
                raise InputError(
                    f"fillet after axle section {step.after} has radius {step.fillet:g} m: "
                    f"give more than the height of the step, {step.high - step.low:g} m"
                )
        for section, low, high in self.cylinders():
            if high <= low:
                raise InputError(f"axle section {section.name} is shorter than its fillets: give smaller radii")

    def steps(self) -> tuple[Step, ...]:
        """Changes of diameter in order of y."""
        found = []
        for this, following in pairwise(self.sections):
            low, high = sorted((this.diameter / 2, following.diameter / 2))
            if high > low:
                direction = 1 if this.diameter > following.diameter else -1
                found.append(Step(this.name, this.end, direction, low, high, this.fillet))
        return tuple(found)

    def cylinders(self) -> list[tuple[AxleSection, float, float]]:
        """Sections with the y at which their cylindrical parts, without fillets, start and end."""
        starts = [self.start, *(section.end for section in self.sections[:-1])]
        ends = [section.end for section in self.sections]
        names = [section.name for section in self.sections]
        for step in self.steps():
            before = names.index(step.after)
            if step.direction > 0:
                starts[before + 1] = step.tangent
            else:
                ends[before] = step.tangent
        return list(zip(self.sections, starts, ends, strict=True))

    def section_over(self, low: float, high: float, what: str) -> AxleSection:
        """Section whose cylinder carries ``what`` from ``low`` to ``high``; raises InputError if none does."""
        for section, start, end in self.cylinders():
            if start <= low and high <= end:
                return section
        raise InputError(
            f"{what} from y = {low:g} to {high:g} m does not sit on the cylinder of one axle section: "
            "move it, or the sections or their fillets"
        )


@dataclass(frozen=True)
class Wheel(Checked):
    """Wheel of straight, tapered web; distances from the track's centre are along the axle."""

    hub_inner: float = quantity("m", 0.3, 1.2, "the distance of the hub's inner face")
    hub_outer: float = quantity("m", 0.3, 1.2, "the distance of the hub's outer face")
    hub_radius: float = quantity("m", 0.05, 0.4, "the outer radius of the hub")
    web: float = quantity("m", 0.3, 1.2, "the distance of the web's middle")
    web_thickness_hub: float = quantity("m", 0.01, 0.2, "the thickness of the web at the hub")
    web_thickness_rim: float = quantity("m", 0.01, 0.2, "the thickness of the web at the rim")
    rim_inner: float = quantity("m", 0.3, 1.2, "the distance of the rim's inner face")
    rim_outer: float = quantity("m", 0.3, 1.2, "the distance of the rim's outer face")
    rim_radius: float = quantity("m", 0.1, 0.7, "the inner radius of the rim")
    rolling_radius: float = quantity("m", 0.15, 0.75, "the radius of the tread")
    flange_width: float = quantity("m", 0.01, 0.06, "the width of the flange at the tread")
    flange_top_width: float = quantity("m", 0.001, 0.06, "the width of the flange at its top")
    flange_height: float = quantity("m", 0.01, 0.06, "the height of the flange over the tread")
    contact: float = quantity("m", 0.3, 1.2, "the distance of the nominal contact point")

    def __post_init__(self) -> None:
        super().__post_init__()
        widest = max(self.web_thickness_hub, self.web_thickness_rim) / 2
        increasing(
            "wheel",
            rim_inner=self.rim_inner,
            flange=self.rim_inner + self.flange_width,
            contact=self.contact,
            rim_outer=self.rim_outer,
        )
        increasing(
            "wheel",
            hub_inner=self.hub_inner,
            web_inner=self.web - widest,
            web_outer=self.web + widest,
            hub_outer=self.hub_outer,
        )
        increasing(
            "wheel",
            flange=self.rim_inner + self.flange_width,
            web_inner=self.web - self.web_thickness_rim / 2,
            web_outer=self.web + self.web_thickness_rim / 2,
            rim_outer=self.rim_outer,
        )
        increasing("wheel", hub_radius=self.hub_radius, rim_radius=self.rim_radius, rolling_radius=self.rolling_radius)

    def web_half_thickness(self, radius: float) -> float:
        """Half the thickness of the web at ``radius``, m."""
        part = (radius - self.hub_radius) / (self.rim_radius - self.hub_radius)
        return (self.web_thickness_hub + part * (self.web_thickness_rim - self.web_thickness_hub)) / 2


@dataclass(frozen=True)
class BrakeDiscs(Checked):
    """Pair of plane discs, one on each side of a wheel's web, on ring-shaped spacers tied to the web."""

    thickness: float = quantity("m", 0.005, 0.1, "the thickness of a disc")
    inner_radius: float = quantity("m", 0.05, 0.6, "the inner radius of a disc")
    outer_radius: float = quantity("m", 0.05, 0.6, "the outer radius of a disc")
    spacer_thickness: float = quantity("m", 0.002, 0.1, "the thickness of a spacer at its mean radius")
    spacer_inner_radius: float = quantity("m", 0.05, 0.6, "the inner radius of a spacer")
    spacer_outer_radius: float = quantity("m", 0.05, 0.6, "the outer radius of a spacer")

    def __post_init__(self) -> None:
        super().__post_init__()
        increasing(
            "brake_discs",
            inner_radius=self.inner_radius,
            spacer_inner_radius=self.spacer_inner_radius,
            spacer_outer_radius=self.spacer_outer_radius,
            outer_radius=self.outer_radius,
        )


@dataclass(frozen=True)
class Gearbox(Checked):
    """Hollow cylinder on the axle that represents the part of the gearbox carried by the axle."""

    y: float = quantity("m", -1.0, 1.0, "the y of the gearbox's middle")
    length: float = quantity("m", 0.02, 1.0, "the length of the gearbox")
    outer_radius: float = quantity("m", 0.05, 0.6, "the outer radius of the gearbox")


@dataclass(frozen=True)
class AxleBoxes(Checked):
    """Axle boxes: a mass at the mean vertical displacement of the journal's bearing surface, and its suspension.

    The surface, ``bearing_length`` long and symmetric about ``distance``, carries the reaction evenly in y and as
    cos(theta) around: unlike a node it gives results that do not depend on the mesh.

    With ``bearing_stiffness`` a spring and a damper stand between journal and box, and the box moves by itself.
    """

    distance: float = quantity("m", 0.5, 1.5, "the distance of an axle box from the track's centre")
    bearing_length: float = quantity("m", 0.02, 0.3, "the length of the bearing surface")
    mass: float = quantity("kg", 0.0, 1000.0, "the mass of one axle box")
    stiffness: float = quantity("N/m", 1e4, 1e9, "the vertical stiffness of one primary suspension")
    damping: float = quantity("N s/m", 0.0, 1e6, "the vertical damping of one primary suspension")
    bearing_stiffness: float | None = quantity(
        "N/m", 1e8, 1e11, "the vertical stiffness of one bearing, with its box", default=None
    )
    """Between journal and box; None is a rigid bearing."""
    bearing_damping: float | None = quantity(
        "N s/m", 0.0, 1e7, "the vertical damping of one bearing, with its box", default=None
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        stiffness, damping = self.bearing_stiffness, self.bearing_damping
        if (stiffness is None) != (damping is None):
            raise InputError("axle_boxes has one of bearing_stiffness and bearing_damping: give both, or none")
        if stiffness is None or damping is None:
            return
        if self.mass < LEAST_BOX:
            raise InputError(
                f"axle_boxes.mass = {self.mass:g} kg is too little for an elastic bearing: give {LEAST_BOX:g} kg or "
                "more, or leave bearing_stiffness out"
            )
        if stiffness < SOFTEST_BEARING * self.stiffness:
            raise InputError(
                f"axle_boxes.bearing_stiffness = {stiffness:g} N/m is below {SOFTEST_BEARING:g} times the suspension's "
                f"{self.stiffness:g} N/m: give the bearing's own stiffness, usually about 1e9 N/m"
            )
        critical = 2.0 * sqrt(stiffness * self.mass)
        if damping > critical:
            raise InputError(
                f"axle_boxes.bearing_damping = {damping:g} N s/m is above the critical damping of the box on its "
                f"bearing: give up to {critical:.4g} N s/m"
            )


@dataclass(frozen=True)
class Material(Checked):
    """Linear elastic material with Rayleigh damping ``C = a M + b K``."""

    density: float = quantity("kg/m3", 500.0, 3e4, "the density")
    youngs_modulus: float = quantity("Pa", 1e9, 1e12, "Young's modulus")
    poissons_ratio: float = quantity("", 0.0, 0.45, "Poisson's ratio")
    mass_damping: float = quantity("1/s", 0.0, 100.0, "the mass-proportional damping")
    stiffness_damping: float = quantity("s", 0.0, 1e-4, "the stiffness-proportional damping")


def increasing(where: str, **values: float) -> None:
    """Raise InputError unless the named lengths increase."""
    for (low_name, low), (high_name, high) in pairwise(values.items()):
        if not low < high:
            raise InputError(
                f"{where}: {low_name} = {low:g} m is not less than {high_name} = {high:g} m: correct one of them"
            )
