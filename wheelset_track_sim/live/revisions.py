"""The one way to a changed run: parameters, services and topics all lead here. Knows nothing of ROS."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from ..bags.tread_damage import irregularities_of
from ..errors import WheelsetTrackError
from ..irregularities.listing import listed
from ..runtime.progress import Progress
from ..scenario import WHEELS, Scenario
from ..simulation.changes import Revision
from ..simulation.simulator import Simulator
from .recorder import path_below

Change = Callable[[Scenario], Scenario]
"""The scenario that is wanted next, from the one accepted last; raises InputError."""


class Outcome(NamedTuple):
    """What became of a change."""

    success: bool
    message: str
    """Why it was refused; empty if it was accepted."""
    revision: int
    """Its number; if it was refused, or changed nothing, that of the newest one."""
    step: int
    """Step from which that revision is in force."""


class Revisions:
    """The scenario accepted last, one change after the other in the order in which they come, each whole or not at all.

    Without a simulator a change is in force from the start of the next run on. Methods may be called in any thread.
    """

    def __init__(self, scenario: Scenario, follow: Callable[[Scenario], None], progress: Progress) -> None:
        """``follow`` is told the scenario after each change that is no parameter's; it may not change it.

        What ``progress`` raises breaks off the change at hand.
        """
        self.lock = threading.RLock()
        """Held from the check of a change until it is known everywhere."""
        self._scenario, self._follow, self._progress = scenario, follow, progress
        self._simulator: Simulator | None = None
        self._newest = Revision(0, 0)

    @property
    def scenario(self) -> Scenario:
        """As accepted last."""
        return self._scenario

    def attach(self, simulator: Simulator) -> None:
        """Changes are those of a run from now on: it gets all that were accepted while it was built.

        Raises what ``change`` raises.
        """
        with self.lock:
            self._simulator, self._newest = None, Revision(0, 0)
            if simulator.scenario != self._scenario:
                self._newest = simulator.apply(self._scenario, self._progress)
                self._scenario = simulator.scenario
            self._simulator = simulator

    def detach(self) -> None:
        """There is no run."""
        with self.lock:
            self._simulator, self._newest = None, Revision(0, 0)

    def change(self, change: Change) -> Revision:
        """Accept a change; the newest revision if it changes nothing.

        Raises WheelsetTrackError if it is refused: an InputError with quantity, value and limit, or a ContactError for
        treads whose contact cannot be worked out.
        """
        with self.lock:
            wanted = change(self._scenario)
            if wanted == self._scenario:
                return self._newest
            if self._simulator is not None:
                self._newest = self._simulator.apply(wanted, self._progress)
                wanted = self._simulator.scenario  # which may have ended its speed plan
            self._scenario = wanted
            return self._newest

    def damage(self, damage: Sequence[Any]) -> Outcome:
        """Replace all irregularities of both treads by messages ``TreadDamage``; those of the rails stay."""

        def change(scenario: Scenario) -> Scenario:
            on_rails = (each for each in scenario.irregularities if each.on not in WHEELS)
            return dataclasses.replace(scenario, irregularities=(*irregularities_of(damage), *on_rails))

        return self._outcome(change)

    def irregularities(self, text: str, folder: str) -> Outcome:
        """Replace all irregularities of treads and rails by a YAML list; files in it lie below ``folder``."""

        def located(name: str) -> str:
            return str(path_below(folder, name))

        return self._outcome(
            lambda scenario: dataclasses.replace(scenario, irregularities=listed(text, located)),
        )

    def speed(self, speed: float, acceleration: float = 0.0) -> Outcome:
        """Approach a speed, m/s; an ``acceleration`` of 0 leaves it as it is. Ends a speed plan."""

        def change(scenario: Scenario) -> Scenario:
            limited = scenario.acceleration if acceleration == 0 else acceleration
            return dataclasses.replace(scenario, speed=speed, acceleration=limited, speed_plan=())

        return self._outcome(change)

    def torque(self, torque: float) -> Outcome:
        """Approach a torque of drive or brake, N m. Ends a torque plan."""

        def change(scenario: Scenario) -> Scenario:
            return dataclasses.replace(
                scenario, loads=dataclasses.replace(scenario.loads, torque=torque, torque_plan=())
            )

        return self._outcome(change)

    def _outcome(self, change: Change) -> Outcome:
        with self.lock:
            try:
                revision = self.change(change)
            except WheelsetTrackError as refusal:
                return Outcome(False, str(refusal), *dataclasses.astuple(self._newest))
            self._follow(self._scenario)
        return Outcome(True, "", *dataclasses.astuple(revision))
