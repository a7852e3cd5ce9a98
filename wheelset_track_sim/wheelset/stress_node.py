"""Where on the axle's surface stress is wanted: by a fillet or by the axial position, and by the angle around the axle.

A node is fixed in space and does not turn with the wheelset, whose rotation the method neglects (Section 2.1 of the
paper): it shows what each point of the axle goes through as it passes there.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

from ..errors import InputError
from ..inputs.schema import check, quantity, unknown
from .parts import Axle, Step

NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
LONGEST_NAME = 60


@dataclass(frozen=True)
class StressNode:
    """Point of the axle's surface, given by one of ``after`` and ``y``."""

    name: str
    """Names the node's topic too: letters, digits and single underscores."""
    after: str | None = None
    """The section at whose end the fillet is: there, the y at which its top is stressed most, statically."""
    y: float | None = quantity("m", -2.0, 2.0, "the axial position", default=None)
    """Axial position, m."""
    angle: float = quantity("rad", -2 * pi, 2 * pi, "the angle from the top, to the front first,", default=0.0)
    """Around the axle in the sense in which it turns: 0 is the top, pi / 2 the front, pi the bottom."""

    def __post_init__(self) -> None:
        check(self, f"stress_nodes.{self.name}")
        if not NAME.fullmatch(self.name) or len(self.name) > LONGEST_NAME:
            raise InputError(
                f"stress node {self.name!r} cannot name a topic: give at most {LONGEST_NAME} letters, digits and "
                "single underscores between them, a letter first"
            )
        if (self.after is None) == (self.y is None):
            raise InputError(f"stress node {self.name} needs its fillet or its position: give one of after and y")

    def on(self, step: Step) -> bool:
        """Whether it is on a fillet."""
        low, high = sorted((step.edge, step.tangent))
        return step.after == self.after if self.y is None else low <= self.y <= high


def check_names(names: Sequence[str]) -> None:
    """Raise InputError unless all stress nodes have topics of their own, which are in lower case."""
    if len({name.lower() for name in names}) < len(names):
        raise InputError(f"stress_nodes has names {', '.join(names)}: give each a name of its own, also in lower case")


def check_stress_nodes(nodes: Sequence[StressNode], axle: Axle, attached: Sequence[tuple[str, float, float]]) -> None:
    """Raise InputError for a node without a fillet, beyond the axle's ends, or under one of the ``attached`` parts.

    A part is what it is with its first and last y, m. Under it the axle has no surface of its own: the solid is tied.
    """
    check_names([node.name for node in nodes])
    after = [step.after for step in axle.steps()]
    for node in nodes:
        where = f"stress_nodes.{node.name}"
        if node.y is None:
            if node.after not in after:
                given = f"{where}.after = {node.after!r}"
                raise InputError(unknown("fillet (section it ends)", given, str(node.after), after))
        else:
            check_free_surface(f"{where}.y", node.y, axle, attached)


def check_free_surface(where: str, y: float, axle: Axle, attached: Sequence[tuple[str, float, float]]) -> None:
    """Raise InputError for a place beyond the axle's ends, or under one of the ``attached`` parts."""
    start, end = axle.start, axle.sections[-1].end
    if not start <= y <= end:
        raise InputError(f"{where} = {y:g} m is not on the axle: give {start:g} to {end:g} m")
    for what, low, high in attached:
        if low <= y <= high:
            raise InputError(f"{where} = {y:g} m is under {what}, {low:g} to {high:g} m: give a y beside it")
