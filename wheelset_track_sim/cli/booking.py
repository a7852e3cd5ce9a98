"""Counts that are kept in a ledger while they go on, and go on from there after a crash."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from ..fatigue.axle import AxleFatigue
from ..fatigue.ledger import Basis, Ledger, LedgerEntry, changed_ledger, load_ledger
from ..samples.block import SampleBlock


@dataclass(frozen=True)
class Booking:
    """Where a count is kept, and under which names."""

    ledger: Path
    axle: str
    run: str
    """Identity of the run."""
    checkpoint: float
    """m"""


class Book:
    """One count with its checkpoints."""

    def __init__(self, fatigue: AxleFatigue, booking: Booking, name: str, first_step: int) -> None:
        """Go on from the last checkpoint if there is one; ``first_step`` is that of the run to count."""
        self._fatigue, self._booking, self._name = fatigue, booking, name
        self._basis = Basis(fatigue.curve, len(fatigue.angles), fatigue.gate)
        ledger = load_ledger(booking.ledger) if booking.ledger.exists() else Ledger(self._basis)
        ledger.basis.require(self._basis, str(booking.ledger))
        known = ledger.open_entry(booking.axle, booking.run)
        if known is not None and known.first_step == first_step:
            fatigue.resume(known.state)
        self._kept = fatigue.steps
        self._every = math.ceil(booking.checkpoint / fatigue.wheel.step_length)

    def push(self, block: SampleBlock) -> None:
        """Take in the next steps; those before the checkpoint are counted already."""
        known = (self._fatigue.next_step or 0) - block.first_step
        if known >= len(block):
            return
        self._fatigue.push(block.part(max(known, 0), len(block)))
        if self._fatigue.steps - self._kept >= self._every:
            self._keep(finished=False)
            self._kept = self._fatigue.steps

    def finish(self) -> str:
        """Write the entry without its state; what it was to the ledger."""
        return self._keep(finished=True)

    def _keep(self, *, finished: bool) -> str:
        booking = self._booking
        entry = LedgerEntry.of(self._fatigue, booking.axle, booking.run, self._name, finished=finished)
        with changed_ledger(booking.ledger, self._basis) as ledger:
            return ledger.put(entry)
