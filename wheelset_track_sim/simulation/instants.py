"""Contacts of a run that may be asked for their pressure: the latest, and those of the largest forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..contact.law_kernels import ContactLaw
from ..contact.solutions import ContactPatch, solve_patch
from ..samples.block import SampleBlock


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact of a wheel at a step, as far as a solution needs it."""

    wheel: int
    """0 or 1."""
    step: int
    tread_step: int
    """Step on the treads of the law, from their row 0 on."""
    angle: float
    """Place on the circumference of the wheel that meets the rail there, rad, from 0 to below 2 pi."""
    approach: float
    """Overlap of the nominal surfaces at the middle of the contact, m."""
    law: ContactLaw

    def solve(self) -> ContactPatch:
        """Pressure and force; ContactError if there is no solution."""
        return solve_patch(self.law, self.wheel, self.tread_step, self.step, self.approach)


@dataclass(frozen=True, eq=False)
class Instant:
    """A contact with its place in the run."""

    contact: Contact
    force: float
    """As simulated, N."""
    time: float
    """Since step 0, s."""
    speed: float
    """m/s"""
    position: float
    """Of the nominal contact point along the track, m."""
    revision: int
    """Number of the accepted change in force."""
    angle: float
    """Place on the circumference of the wheel that met the rail there, rad, from 0 to below 2 pi."""


class WheelContacts(Protocol):
    """A run that hands over the contacts of its latest block, as ``Simulator`` does."""

    def contact(self, wheel: int, row: int) -> Contact:
        """Contact of ``wheel`` (0 or 1) at sample ``row`` of the latest block."""
        ...


class Contacts:
    """The latest contact of each wheel, and that of its largest force since the start; solved only when asked for."""

    def __init__(self) -> None:
        self.latest: tuple[Instant, ...] = ()
        """Of wheel 1 and 2; empty before the first block."""
        self.worst: tuple[Instant, ...] = ()
        """Likewise: at the first step with the largest force."""

    def push(self, run: WheelContacts, block: SampleBlock) -> None:
        """Take in ``block``, the latest of ``run``."""
        if len(block) == 0:
            return
        wheels = range(block.forces.shape[1])
        self.latest = tuple(_instant(run, block, wheel, len(block) - 1) for wheel in wheels)
        rows = [int(block.forces[:, wheel].argmax()) for wheel in wheels]
        self.worst = tuple(
            self.worst[wheel]
            if self.worst and block.forces[row, wheel] <= self.worst[wheel].force
            else _instant(run, block, wheel, row)
            for wheel, row in enumerate(rows)
        )


def _instant(run: WheelContacts, block: SampleBlock, wheel: int, row: int) -> Instant:
    contact = run.contact(wheel, row)
    return Instant(
        contact=contact,
        force=float(block.forces[row, wheel]),
        time=block.time + row * block.step_period,
        speed=block.speed,
        position=block.position + row * (block.speed * block.step_period),
        revision=block.revision,
        angle=contact.angle,
    )
