"""Contacts kept for later: the pressure that is solved then is that of the step."""

import dataclasses
import math

import numpy as np
import pytest

from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.instants import Contacts
from wheelset_track_sim.simulation.simulator import Simulator

TURN = 2713


@pytest.fixture(scope="module")
def run():
    """A turn in blocks, the contacts after each, and what was solved at once for the largest force of each wheel."""
    simulator, contacts = Simulator(load_scenario("damage_wheel_1")), Contacts()
    forces, solved = [], {}
    while simulator.next_step < TURN:
        block = simulator.advance(min(400, TURN - simulator.next_step))
        contacts.push(simulator, block)
        for wheel in (0, 1):
            row = int(block.forces[:, wheel].argmax())
            if block.forces[row, wheel] > solved.get(wheel, (0.0,))[0]:
                solved[wheel] = block.forces[row, wheel], simulator.contact_patch(wheel, row)
        forces.append(block.forces)
    latest = [simulator.contact_patch(wheel, len(forces[-1]) - 1) for wheel in (0, 1)]
    simulator.apply(load_scenario("undamaged"))
    while simulator.revision == 0:
        simulator.advance(400)  # other treads, other displacements: what is kept must not change with them
    return contacts, np.concatenate(forces), [solved[wheel][1] for wheel in (0, 1)], latest


def test_the_worst_is_the_first_largest_force_of_each_wheel(run):
    contacts, forces, solved, _ = run
    for wheel, found in enumerate(contacts.worst):
        step = int(forces[:, wheel].argmax())
        assert (found.contact.wheel, found.contact.step, found.force) == (wheel, step, forces[step, wheel])
        assert found.angle == pytest.approx((step - 1800) % TURN * 2 * math.pi / TURN)
        assert found.position == pytest.approx(step * 1e-3, rel=1e-12)
        assert found.time == pytest.approx(found.position / found.speed, rel=1e-12)
        patch = found.contact.solve()
        assert patch.force == pytest.approx(found.force, rel=1e-6)  # by a table there, by the active set here
        np.testing.assert_array_equal(patch.pressure, solved[wheel].pressure)
    assert contacts.worst[0].force > 2.5 * 98.1e3


def test_the_latest_is_the_last_sample(run):
    contacts, forces, _, latest = run
    for wheel, found in enumerate(contacts.latest):
        assert found.contact.step == TURN - 1
        assert found.force == forces[-1, wheel]
        np.testing.assert_array_equal(found.contact.solve().pressure, latest[wheel].pressure)


def test_a_wheel_in_the_air_has_no_pressure(run):
    contacts, *_ = run
    aloft = dataclasses.replace(contacts.latest[0].contact, approach=-1e-3).solve()
    assert aloft.force == 0.0
    assert not aloft.pressure.any()


def test_nothing_is_kept_of_nothing():
    assert Contacts().latest == Contacts().worst == ()
