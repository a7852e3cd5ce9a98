"""The unit of the stream: a gap-free run of samples at one speed and one revision."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from ..runtime.arrays import Real
from .principal import maximum_principal


@dataclass(frozen=True)
class ContactCounts:
    """How contacts without a force table were found; each step counts once for each wheel."""

    solved_steps: int = 0
    """Solved."""
    filtered_steps: int = 0
    """Filtered (``contact.ordered.hinge_kernels``)."""
    largest_estimate: float = 0.0
    """Largest estimate of the error of a filtered force, N; NaN if it is not known how contacts were found."""

    def __add__(self, other: ContactCounts) -> ContactCounts:
        estimates = self.largest_estimate, other.largest_estimate
        return ContactCounts(
            self.solved_steps + other.solved_steps,
            self.filtered_steps + other.filtered_steps,
            math.nan if any(map(math.isnan, estimates)) else max(estimates),
        )


NO_CONTACTS = ContactCounts()
UNCOUNTED = ContactCounts(largest_estimate=math.nan)
"""Of samples that were recorded without counts."""


@dataclass(frozen=True, eq=False)
class SampleBlock:
    """Consecutive samples, one for each step unless it is decimated; the arrays are read-only.

    A simulation, a bag and a replay yield the same blocks. The block length carries no meaning: the same run cut
    differently holds the same numbers, bit by bit.

    Examples
    --------
    >>> block = Simulator(load_scenario("undamaged")).advance(1000)
    >>> len(block), block.nodes, block.forces.shape, block.max_principal.shape
    (1000, ('A1', 'B1', 'C1'), (1000, 2), (1000, 3))
    """

    first_step: int
    """Index of the first sample; counts from 0 and never repeats in a run."""
    time: float
    """Simulated time of the first sample since step 0, s."""
    step_period: float
    """Time from sample to sample, s."""
    speed: float
    """m/s, constant within the block."""
    position: float
    """Position of the first sample along the track, ``first_step * dx``, m."""
    revision: int
    """Number of the accepted change that is in force, from 0."""
    forces: Real
    """Contact forces of wheel 1 and wheel 2, (samples, 2), N, positive in compression."""
    stresses: Real
    """Axle stress, (samples, nodes, 6), Pa, components in the order of ``COMPONENTS``."""
    nodes: tuple[str, ...]
    """Names of the stress nodes."""
    decimation: int = 1
    """Steps from sample to sample."""
    contacts: ContactCounts = NO_CONTACTS
    """How contacts were found; of a simulation alone."""
    sensors: Mapping[str, Real] = field(default_factory=dict)
    """True values at the sensors of the scenario, by topic: (samples, channels) in SI units; of a simulation alone."""

    def __post_init__(self) -> None:
        self.forces.flags.writeable = False
        self.stresses.flags.writeable = False

    def __len__(self) -> int:
        return len(self.forces)

    def part(self, start: int, stop: int) -> SampleBlock:
        """Samples from ``start`` to before ``stop``, without those of sensors."""
        if start == 0 and stop == len(self):
            return self
        return dataclasses.replace(
            self,
            first_step=self.first_step + start * self.decimation,
            time=self.time + start * self.step_period,
            position=self.position + start * self.step_period * self.speed,
            forces=self.forces[start:stop],
            stresses=self.stresses[start:stop],
            contacts=NO_CONTACTS,
            sensors={},
        )

    @cached_property
    def max_principal(self) -> Real:
        """Maximum principal stress, (samples, nodes), Pa."""
        return maximum_principal(self.stresses)
