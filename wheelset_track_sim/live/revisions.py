"""The one way to change a run: parameters, services and topics all lead here; without ROS."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from ..bags.tread_damage import irregularities_of
from ..irregularities.listing import listed
from ..runtime.progress import Progress
from ..scenario import WHEELS, Scenario
from ..scenario.events import listed_events
from ..simulation.agenda import in_order
from ..simulation.changes import OvertakenError, Revision
from ..simulation.simulator import Simulator
from ..simulation.speed import course_of
from .recorder import path_below


class Revisions:
    """The scenario accepted last, and the changes of it: one after the other, each complete or not at all.

    Every change returns its revision; if it changes nothing, the newest one. A rejected change raises
    WheelsetTrackError: an InputError with quantity, value and limit, or a ContactError for treads whose contact cannot
    be solved. Without a simulator, a change takes effect at the start of the next run. Methods may be called from any
    thread.

    Events of the run change its scenario, too. ``catch_up`` makes them known, and each change is made from the scenario
    after them.
    """

    def __init__(self, scenario: Scenario, follow: Callable[[Scenario], None], progress: Progress) -> None:
        """``follow`` is called with the scenario after each change that parameters did not make; it must not change it.

        An exception from ``progress`` breaks off the current change.
        """
        self.lock = threading.RLock()
        """Held while a change is validated, accepted and followed."""
        self._known, self._follow, self._progress = scenario, follow, progress
        self._simulator: Simulator | None = None
        self._newest = Revision(0, 0)

    @property
    def scenario(self) -> Scenario:
        """The scenario accepted last."""
        simulator = self._simulator
        return self._known if simulator is None else simulator.scenario

    @property
    def newest(self) -> Revision:
        """The revision accepted last, or known last if an event has just made another one."""
        return self._newest

    def attach(self, simulator: Simulator) -> None:
        """Apply changes to a run from now on, beginning with all that were accepted while it was built.

        Raises WheelsetTrackError if it cannot take them; then there is no run.
        """
        with self.lock:
            self.detach()
            if simulator.scenario != self._known:
                self._newest = simulator.apply(self._known, self._progress)
            self._known, self._simulator = simulator.scenario, simulator

    def detach(self) -> None:
        """Apply changes to no run."""
        with self.lock:
            self.catch_up()
            self._simulator, self._newest = None, Revision(0, 0)

    def begin(self, scenario: Scenario) -> None:
        """Begin anew with another scenario, without a run; parameters show it."""
        with self.lock:
            self.detach()
            self._known = scenario
            self._follow(scenario)

    def catch_up(self) -> None:
        """Take note of what events have changed."""
        with self.lock:
            simulator = self._simulator
            if simulator is not None and simulator.scenario is not self._known:
                self._known, self._newest = simulator.accepted
                self._follow(self._known)

    def change(self, change: Callable[[Scenario], Scenario]) -> Revision:
        """Make a change by parameters: ``change`` returns the next scenario from the one accepted last.

        Raises OvertakenError if an event happens meanwhile; ``catch_up``, and make it again.
        """
        with self.lock:
            wanted, simulator = change(self._known), self._simulator
            if wanted == self._known:
                return self._newest
            if simulator is None:
                self._known = wanted
                return self._newest
            self._newest = simulator.apply(wanted, self._progress, base=self._known)
            scenario, revision = simulator.accepted  # without its speed plan, if the change ended that
            if revision == self._newest:
                self._known = scenario
            return self._newest

    def damage(self, damage: Sequence[Any]) -> Revision:
        """Replace all irregularities of both treads by messages ``TreadDamage``; those of the rails stay."""

        def change(scenario: Scenario) -> Scenario:
            on_rails = (each for each in scenario.irregularities if each.on not in WHEELS)
            return dataclasses.replace(scenario, irregularities=(*irregularities_of(damage), *on_rails))

        return self._change_and_follow(change)

    def irregularities(self, text: str, folder: str) -> Revision:
        """Replace all irregularities of treads and rails by a YAML list; files in it lie below ``folder``."""

        def located(name: str) -> str:
            return str(path_below(folder, name))

        return self._change_and_follow(
            lambda scenario: dataclasses.replace(scenario, irregularities=listed(text, located))
        )

    def speed(self, speed: float, acceleration: float = 0.0) -> Revision:
        """Approach a speed, m/s; an ``acceleration`` of 0 leaves it as it is. Ends a speed plan."""

        def change(scenario: Scenario) -> Scenario:
            limited = scenario.acceleration if acceleration == 0 else acceleration
            return dataclasses.replace(scenario, speed=speed, acceleration=limited, speed_plan=())

        return self._change_and_follow(change)

    def torque(self, torque: float) -> Revision:
        """Approach a torque of drive or brake, N m. Ends a torque plan."""

        def change(scenario: Scenario) -> Scenario:
            loads = dataclasses.replace(scenario.loads, torque=torque, torque_plan=())
            return dataclasses.replace(scenario, loads=loads)

        return self._change_and_follow(change)

    def schedule(self, text: str, folder: str, *, replace: bool = False) -> Revision:
        """Add a YAML list of events to those to come, or ``replace`` them; files in it lie below ``folder``."""
        events = listed_events(text, lambda name: str(path_below(folder, name)))

        def change(scenario: Scenario) -> Scenario:
            simulator = self._simulator
            course = course_of(scenario) if simulator is None else simulator.course
            coming = (*(() if replace else scenario.events), *events)
            return dataclasses.replace(scenario, events=in_order(coming, scenario, course))

        return self._change_and_follow(change)

    def _change_and_follow(self, change: Callable[[Scenario], Scenario]) -> Revision:
        while True:
            with self.lock, suppress(OvertakenError):
                self.catch_up()
                revision = self.change(change)
                self._follow(self._known)
                return revision
