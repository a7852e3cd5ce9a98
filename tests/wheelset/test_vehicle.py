"""A wheelset under its vehicle: a rigid one against the equations of its masses, written down once more."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.wheelset.imported import ImportedNode, ImportedWheelset, Modes
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.vehicle import FLOAT, FLOAT_DAMPING, LONGEST_SETTLING, Vehicle, load_vehicle

MASS, INERTIA = 1800.0, 900.0  # kg, kg m^2 about x
SPRING, DASHPOT = 2e6, 2e4
BOX, CONTACT = 1.0, 0.75  # m from the middle
FRAME = Vehicle(bogie_mass=1400.0, secondary_stiffness=4.4e5, secondary_damping=2.25e4)
BODY = dataclasses.replace(FRAME, body_mass=7400.0)
FREQUENCIES = np.array([0.0, 0.05, 0.1, 0.3, 1.0, 1.39, 3.0, 7.0, 20.0, 100.0])


def rigid(bending: bool = False) -> ImportedWheelset:
    """Bounce and roll of a rigid wheelset on its springs, and a mode that bends the axle, if wanted."""
    bounce, roll = np.sqrt(2 * SPRING / MASS), np.sqrt(2 * SPRING * BOX**2 / INERTIA)
    lift, boxes = [(1.0, 1.0), (-CONTACT, CONTACT)], [(1.0, 1.0), (-BOX, BOX)]
    frequencies, masses = [bounce / (2 * np.pi), roll / (2 * np.pi)], [MASS, INERTIA]
    nodes = ()
    if bending:
        lift, boxes = [*lift, (0.5, 0.5)], [*boxes, (-0.8, -0.8)]
        frequencies, masses = [*frequencies, 80.0], [*masses, 1500.0]
        modal = tuple((0.0, s, 0.0, 0.0, 0.0, 0.0) for s in (2e9, 1e9, 5e10))
        nodes = (ImportedNode("A1", (0.0, 0.0, 0.09), modal, tuple([(0.0, 700.0, 0.0, 0.0, 0.0, 0.0)] * 2)),)
    modes = Modes(
        lift=tuple(lift),
        frequencies=tuple(frequencies),
        damping_ratios=(1e-7,) * len(lift),
        modal_masses=tuple(masses),
        suspension=tuple(boxes),
    )
    return ImportedWheelset(
        1, "rigid", modes, rolling_radius=0.45, mass=MASS, stress_nodes=nodes, suspension_damping=DASHPOT
    )


def of_masses(vehicle: Vehicle, frequencies: np.ndarray) -> np.ndarray:
    """Receptances (F, 2, 2) at the contacts from bounce, roll, and the lift of frame and body on each side."""
    k, c = vehicle.secondary_stiffness, vehicle.secondary_damping
    found = []
    for omega in 2 * np.pi * frequencies:
        Z = np.zeros((6, 6), complex)
        Z[range(6), range(6)] = -(omega**2) * np.array([MASS, INERTIA, *[vehicle.bogie_mass] * 2, *[0.0] * 2])
        ground = 1e30  # of a body that does not move
        if vehicle.body_mass is not None:
            own = 2 * np.pi * FLOAT
            ground = vehicle.body_mass * (own**2 + 2j * FLOAT_DAMPING * own * omega - omega**2)
        for side, y in enumerate((-BOX, BOX)):
            primary = np.zeros(6)
            primary[[0, 1, 2 + side]] = 1.0, y, -1.0
            secondary = np.zeros(6)
            secondary[[2 + side, 4 + side]] = 1.0, -1.0
            Z += (SPRING + 1j * omega * DASHPOT) * np.outer(primary, primary)
            Z += (k + 1j * omega * c) * np.outer(secondary, secondary)
            Z[4 + side, 4 + side] += ground
        contacts = np.zeros((6, 2))
        contacts[:2] = [[1.0, 1.0], [-CONTACT, CONTACT]]
        found.append(contacts.T @ np.linalg.solve(Z, contacts))
    return np.array(found)


@pytest.mark.parametrize("vehicle", [FRAME, BODY, load_vehicle("coach"), load_vehicle("power_car")])
def test_receptances_are_those_of_the_masses(vehicle: Vehicle) -> None:
    found, expected = rigid().reduced(vehicle).receptance(FREQUENCIES), of_masses(vehicle, FREQUENCIES)
    error = np.abs(found - expected).max(axis=(1, 2)) / np.abs(expected).max(axis=(1, 2))
    assert error.max() < (1e-6 if vehicle.body_mass is None else 1e-5)  # resonances stand on damping ratios of 1e-7


def test_static_compliances_are_springs_in_series() -> None:
    for vehicle, springs in ((FRAME, (SPRING, 4.4e5)), (BODY, (SPRING, 4.4e5, 7400.0 * (2 * np.pi * FLOAT) ** 2))):
        both = rigid().reduced(vehicle).static_receptance().sum(axis=1)
        assert both == pytest.approx([sum(1 / spring for spring in springs)] * 2, rel=1e-6)


def test_a_frame_that_cannot_move_is_a_fixed_end() -> None:
    held = dataclasses.replace(FRAME, bogie_mass=1e6, secondary_stiffness=1e9)
    frequencies = np.array([0.0, 1.0, 3.0, 7.0, 30.0])
    fixed, found = rigid().reduced(), rigid().reduced(held)
    assert found.receptance(frequencies) == pytest.approx(fixed.receptance(frequencies), rel=0.01, abs=1e-12)
    heavy = dataclasses.replace(FRAME, bogie_mass=1e6)
    frequencies = np.array([4.0, 7.0, 30.0])
    assert rigid().reduced(heavy).receptance(frequencies) == pytest.approx(
        fixed.receptance(frequencies), rel=0.01, abs=1e-12
    )


@pytest.mark.parametrize("vehicle", [FRAME, BODY])
def test_no_force_on_the_wheels_gets_energy_out_of_it(vehicle: Vehicle) -> None:
    reduced = rigid().reduced(vehicle)
    assert (reduced.poles.real < 0.0).all()
    frequencies = np.geomspace(0.01, 300.0, 200)
    power = 1j * frequencies[:, None, None] * reduced.receptance(frequencies)  # of velocity over force
    assert np.linalg.eigvalsh(power + power.conj().transpose(0, 2, 1)).min() > 0.0


@pytest.mark.parametrize("vehicle", [FRAME, BODY])
def test_a_slow_load_strains_the_axle_as_it_does_on_fixed_springs(vehicle: Vehicle) -> None:
    """Two contacts on two boxes are statically determinate; what the masses do at 0.02 Hz is below 1e-3."""
    fixed, found = rigid(bending=True).reduced(), rigid(bending=True).reduced(vehicle)
    assert found.static_stress() == pytest.approx(fixed.static_stress(), rel=1e-9)
    assert fixed.static_stress()[0, 1] == pytest.approx([700.0, 700.0])
    slow = found.stress_receptance(np.array([1e-3, 0.02]))[:, 0, 1, 0]
    assert np.abs(slow - 700.0).max() < (0.05 if vehicle.body_mass else 0.002) * 700.0


def test_other_modes_stay_where_they_are() -> None:
    fixed, found = rigid(bending=True).reduced(), rigid(bending=True).reduced(FRAME)
    assert isinstance(found, ReducedWheelset)
    assert len(found.poles) == len(fixed.poles) + 2
    assert found.poles[-1].imag == pytest.approx(fixed.poles[-1].imag, rel=2e-3)


def test_the_suspension_of_imported_modes_follows_from_equilibrium() -> None:
    wheelset = rigid()
    assert wheelset.suspension_stiffness == pytest.approx(SPRING, rel=1e-9)
    without = dataclasses.replace(
        wheelset, suspension_damping=0.0, modes=dataclasses.replace(wheelset.modes, suspension=())
    )
    assert len(without.reduced().poles) == 2
    with pytest.raises(InputError, match=r"^a vehicle needs the modes' lift at the suspension: give modes\.suspension"):
        without.reduced(FRAME)
    lame = dataclasses.replace(wheelset.modes, suspension=((1.0, 1.0), (-BOX, 0.5 * BOX)))
    with pytest.raises(InputError, match=r"give bounce and roll on two equal suspensions"):
        dataclasses.replace(wheelset, modes=lame).reduced(FRAME)


def test_a_vehicle_settles_as_fast_as_its_slowest_motion() -> None:
    assert FRAME.settling(SPRING, DASHPOT) == pytest.approx(np.log(100) * 2 * 1400.0 / (2e4 + 2.25e4), rel=1e-6)
    assert 3.0 < BODY.settling(SPRING, DASHPOT) < 5.0
    assert dataclasses.replace(BODY, secondary_damping=0.0).settling(SPRING, 0.0) == LONGEST_SETTLING
