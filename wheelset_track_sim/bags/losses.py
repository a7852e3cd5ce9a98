"""Missing and damaged parts of a bag."""

from __future__ import annotations

from dataclasses import dataclass

LONGEST_GAP = 10**8
"""Steps that may be missing between two blocks of a run: an hour of it."""


@dataclass(frozen=True)
class Damage:
    """Bytes of a file that cannot be read, or another fault of it."""

    file: str
    place: int
    """First byte."""
    end: int
    """First byte after it; ``place`` if no bytes are lost."""
    reason: str

    @classmethod
    def again(cls, file: str, step: int, end_step: int) -> Damage:
        """Another run, as after a reset: it begins before ``end_step``, the end of the first one."""
        words = f"steps from {step} on come again after step {end_step - 1}: all that follows is left out"
        return cls(file, 0, 0, words)

    @classmethod
    def far(cls, file: str, step: int, end_step: int) -> Damage:
        """Samples so long after ``end_step`` that they are not of the run."""
        words = f"step {step} comes after step {end_step - 1}: a gap of more than {LONGEST_GAP} steps ends the run"
        return cls(file, 0, 0, f"{words}, and all that follows is left out")

    @property
    def what(self) -> str:
        """Description without the name of the file."""
        return f"bytes {self.place} to {self.end - 1}: {self.reason}" if self.end > self.place else self.reason

    def __str__(self) -> str:
        return f"{self.file}: {self.what}"


@dataclass(frozen=True)
class Gap:
    """Steps that are missing between two blocks."""

    first_step: int
    steps: int
    seconds: float
    """Simulated time between the samples before and after that is not there."""

    @classmethod
    def between(cls, end_step: int, end_time: float, step: int, time: float) -> Gap | None:
        """Gap from the end of a block (the step and time that should come next) to another; None without one."""
        return cls(end_step, step - end_step, time - end_time) if step > end_step else None

    def __str__(self) -> str:
        last = self.first_step + self.steps - 1
        return f"steps {self.first_step} to {last} are missing ({self.seconds:.4g} s)"


Loss = Damage | Gap
