"""The coupled step without shortcuts, in NumPy: every mode of wheelset and ring, stress of every mode, contact solved.

What the package runs differs from it by the reduction of the ring to a few states, by whatever modes and products it
leaves out because they hardly count, by force tables, and by the order of its sums. The physics is the same: loads
are linear within a step, and no force crosses axle or sleepers within the step at which it acts.
"""

from __future__ import annotations

import copy

import numpy as np

from wheelset_track_sim.contact.law import build_contact_law
from wheelset_track_sim.contact.law_kernels import ContactLaw
from wheelset_track_sim.contact.solutions import approach_for_force, force_at
from wheelset_track_sim.dynamics.hold import hold
from wheelset_track_sim.scenario import Scenario
from wheelset_track_sim.simulation.models import Models
from wheelset_track_sim.track.ring import track_ring
from wheelset_track_sim.wheelset.reduction import reduced_wheelset

IN_HALF = np.array([[0.5, 0.5], [0.5, -0.5]])
"""Share of the forces on both rails in the load of the symmetric and of the antisymmetric half."""


class Unreduced:
    """One wheelset on the whole ring at one speed; of ``models`` it has the contact's geometry and the grid of steps.

    It starts at ``first_step``, at rest under the static load.
    """

    def __init__(self, scenario: Scenario, models: Models, first_step: int) -> None:
        self.models, self.step, self.load = models, first_step, scenario.wheel_load
        self.dx, dt = scenario.step_length, scenario.step_period
        self.wheelset = wheelset = reduced_wheelset(models.wheelset)
        ring = track_ring(models.track, self.dx)
        self.halves = ring.symmetric, ring.antisymmetric

        self.a, b0, b1 = _step(wheelset.poles, dt)
        held = b1[:, None] * wheelset.inputs
        self.gain = self.a[:, None] * held + b0[:, None] * wheelset.inputs
        self.stress_at_once = (wheelset.stress_outputs @ held).real + wheelset.stress_feedthrough
        at_once = (wheelset.outputs * held.T).real.sum(axis=1)
        static = wheelset.inputs.sum(axis=1) * self.load
        self.q = -static / wheelset.poles - b1 * static

        place = first_step % len(self.halves[0].residual)
        self.track_a, self.track_gain, self.r = [], [], []
        rail_at_once = np.zeros(len(self.halves[0].residual))
        for half, load in zip(self.halves, (self.load, 0.0), strict=True):
            a, b0, b1 = _step(half.moving_poles(scenario.speed), dt)
            self.track_a.append(a)
            self.track_gain.append((a * b1 + b0) * half.input)
            rail_at_once += ((half.output * b1 * half.input).real.sum(axis=1) + half.residual) / 2
            self.r.append(-half.input[place] * load / half.poles - b1 * half.input[place] * load)
        self.compliance = at_once + rail_at_once[:, None]

        even = self.halves[0]
        rail = (even.residual - (even.output * even.input / even.poles).real.sum(axis=1)).mean()
        undeformed = approach_for_force(models.contact_law(()), 0, 0, 0, self.load)
        self.preload = (wheelset.static_receptance().sum(axis=1) + rail) * self.load + undeformed

    def copy(self) -> Unreduced:
        """Another run from here on."""
        return copy.deepcopy(self, {id(self.models): self.models})

    def solver(self, scenario: Scenario) -> ContactLaw:
        """Contact law without tables."""
        steps = self.models.steps_per_revolution
        return build_contact_law(scenario.irregularities, self.models.geometry, self.dx, steps, tables=False)

    def run(self, law: ContactLaw, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Forces (steps, 2) in N and stresses (steps, nodes, 6) in Pa of the next steps."""
        forces, stress = np.zeros((steps, 2)), np.zeros((steps, *self.stress_at_once.shape[:2]))
        for row in range(steps):
            place = self.step % len(self.compliance)
            of_halves = [(half.output[place] @ r).real for half, r in zip(self.halves, self.r, strict=True)]
            approach = self.preload - (self.wheelset.outputs @ self.q).real - of_halves @ IN_HALF * 2
            tread = self.step - self.models.tread_origin
            for wheel in range(2):
                compliance = self.compliance[place, wheel]
                forces[row, wheel] = force_at(law, wheel, tread, self.step, approach[wheel], compliance)
            stress[row] = (self.wheelset.stress_outputs @ self.q).real + self.stress_at_once @ forces[row]
            self.q = self.a * self.q + self.gain @ forces[row]
            for index, load in enumerate(IN_HALF @ forces[row]):
                self.r[index] = self.track_a[index] * self.r[index] + self.track_gain[index][place] * load
            self.step += 1
        return forces, stress


def _step(poles: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return hold(poles, dt)
