"""Both contacts, wheelset and track at the step that they have come to."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from ..contact.law_kernels import ContactLaw
from ..contact.solutions import contact_filter, solver
from ..errors import ContactError, DivergenceError
from ..runtime.arrays import Real
from ..samples.block import NO_CONTACTS, ContactCounts
from .changes import Condition
from .coupled_kernels import run
from .models import Models

AHEAD = 2
"""Coming speeds whose coefficients are worked out while steps are taken."""
_POOL = ThreadPoolExecutor(max_workers=AHEAD, thread_name_prefix="speeds-ahead")


class Coupled:
    """The coupled system, stepped under a condition at a speed; its state carries over exactly from one to the next."""

    def __init__(self, models: Models, wheel_load: float, step: int, speed: float) -> None:
        """At rest, or in steady running, under ``wheel_load`` N on both wheels at ``step``."""
        self.models = models
        self._dynamics = models.dynamics.start(wheel_load, step, models.step_length, speed)
        self._speed = self._speed_behind = speed
        self._ahead: dict[float, Future[None]] = {}
        self._next = step
        self._xi = np.empty((0, 2, 2))
        self._signals = np.empty((0, models.dynamics.sensor_rows))
        self._contacts = NO_CONTACTS

    def copy(self) -> Coupled:
        """The same state, which goes on by itself."""
        copied = copy.copy(self)
        copied._dynamics = self.models.dynamics.copied(self._dynamics)
        copied._ahead = {}
        return copied

    def prepare(self, law: ContactLaw) -> None:
        """Compile what steps under a law call; the run may go on in another thread meanwhile."""
        nothing, stress = np.empty((0, 2)), np.empty((0, len(self.models.dynamics.stress_rows)))
        run(
            self._dynamics,
            law,
            solver(law),
            contact_filter(law),
            nothing,
            0,
            0,
            nothing,
            stress,
            np.empty((0, self.models.dynamics.sensor_rows)),
            np.empty((0, 2, 2)),
            np.zeros(3),
        )

    @property
    def next_step(self) -> int:
        """Index of the next sample."""
        return self._next

    @property
    def displacements(self) -> Real:
        """Displacements of the latest block, (samples, 2, 2), m: wheels and rails away from each other, by wheel."""
        return self._xi

    @property
    def signals(self) -> Real:
        """Rows of sensors of the latest block, (samples, rows), SI units."""
        return self._signals

    @property
    def contacts(self) -> ContactCounts:
        """How the contacts of the latest block were found."""
        return self._contacts

    def run(self, condition: Condition, speed: float, preload: Real, ahead: Sequence[float] = ()) -> tuple[Real, Real]:
        """Forces (n, 2) N and stress components (n, S) Pa of the next n steps at ``speed`` m/s.

        ``preload`` (n, 2) m is that of each step; ``ahead`` are the speeds that come next. The steps
        are fewer if a contact problem has no solution after them; ContactError is raised if it is the first. Raises
        DivergenceError if a sample is not finite.
        """
        self._make_ready(speed, ahead)
        filtered = condition.law.hinges.element.size > 0
        largest = self.models.tolerance * condition.scenario.wheel_load if filtered else 0.0
        law, steps = condition.law._replace(largest_estimate=largest), len(preload)
        tables = len(law.nested[0].element) == 0
        forces = np.empty((steps, 2))
        stress = np.empty((steps, len(self.models.dynamics.stress_rows)))
        signals = np.empty((steps, self.models.dynamics.sensor_rows))
        xi = np.empty((steps, 2, 2))
        untabled = np.zeros(3)
        done = 0
        while done < steps:
            stop = self._set_speed(speed, done, steps)
            solved = 0
            for solving in (False, True) if tables else (True,):  # solving only behind what tables do
                part = slice(done + solved, stop)
                solved += run(
                    self._dynamics,
                    law,
                    solver(law) if solving else None,
                    contact_filter(law) if solving else None,
                    preload[part],
                    condition.tread_origin,
                    self._next + solved,
                    forces[part],
                    stress[part],
                    signals[part],
                    xi[part],
                    untabled,
                )
                if done + solved == stop:
                    break
            self._next += solved
            done += solved
            if done < stop:
                if done == 0:
                    self._refuse(preload, xi)
                break
        self._contacts = ContactCounts(int(untabled[0]), int(untabled[1]), float(untabled[2]))
        forces, stress, self._signals, self._xi = forces[:done], stress[:done], signals[:done], xi[:done]
        sensed = {"sensors": self._signals} if self._signals.size else {}
        require_finite(self._next - done, forces=forces, displacements=self._xi, stress=stress, **sensed)
        return forces, stress

    def _make_ready(self, speed: float, ahead: Sequence[float]) -> None:
        """Wait for the coefficients of ``speed`` if they are under way, have those of coming ones begun.

        It changes no result: what is not ready is worked out when it is needed.
        """
        if speed in self._ahead:
            self._ahead[speed].result()
        prepare, dx = self.models.dynamics.prepare, self.models.step_length
        self._ahead = {coming: self._ahead.get(coming) or _POOL.submit(prepare, dx, coming) for coming in ahead}

    def _set_speed(self, speed: float, done: int, stop: int) -> int:
        """Coefficients for ``speed``; the one step at which it changes has its own, and is run alone."""
        if speed == self._speed == self._speed_behind:
            return stop
        changes = speed != self._speed
        self._speed_behind = self._speed if changes else speed
        self._speed = speed
        models = self.models
        self._dynamics = models.dynamics.at_speed(
            self._dynamics, self._next, models.step_length, speed, self._speed_behind
        )
        return done + 1 if changes else stop

    def _refuse(self, preload: Real, xi: Real) -> None:
        approach = preload[0] - xi[0].sum(axis=0)
        raise ContactError(
            f"the contact problem of step {self._next} has no solution: approach of wheel 1 and 2 is "
            f"{approach[0]:g} and {approach[1]:g} m, beyond what half-spaces of this size can carry"
        )


def require_finite(first_step: int, **samples: Real) -> None:
    """Raise DivergenceError if any of the samples (n, ...) from ``first_step`` on is not finite.

    The error names the first such step and the values of all samples at that step.
    """
    if all(np.isfinite(values).all() for values in samples.values()):
        return
    bad = np.any([~np.isfinite(values.reshape(len(values), -1)).all(axis=1) for values in samples.values()], axis=0)
    row = int(bad.argmax())
    shown = ", ".join(
        f"{name} {np.array2string(values[row].ravel(), precision=6, max_line_width=10**9)}"
        for name, values in samples.items()
    )
    raise DivergenceError(f"step {first_step + row} is not finite ({shown}): the models at this speed are not stable")
