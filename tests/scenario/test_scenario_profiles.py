import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.contact import approach_for_force, build_contact_law, contact_force, force_at
from wheelset_track_sim.contact.law_kernels import total_separation
from wheelset_track_sim.contact.named_profiles import read_profile
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import Profiles, load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.wheelset.kinds import load_wheelset

X40 = load_wheelset("x40")


def geometry_of(name="undamaged", *changes):
    return load_scenario(name, changes).geometry


def law_of(geometry, irregularities=(), tables=False):
    return build_contact_law(irregularities, geometry, 1e-3, 2713, tables=tables)


def test_the_default_is_the_papers():
    geometry = geometry_of()
    for wheel in (0, 1):
        assert geometry.touch(wheel) == geometry.rolling_circle(wheel) == 0.0
    wheelset = load_scenario("undamaged").touched_wheelset
    assert wheelset.contact_positions == (-0.75, 0.75)


def test_gauge_and_inclination_place_the_rails():
    geometry = geometry_of("undamaged", "profiles.gauge=1.435")
    # Heads of 60E1 are 72 mm wide: their middles are 1507 mm apart, and the rolling circles 1500.
    assert geometry.pairs[0].shift == pytest.approx(-3.5e-3, abs=3e-5)
    assert geometry.rolling_circle(0) == -geometry.rolling_circle(1) > 0
    # A cone 1:40 is parallel to the crown of a rail that leans by 1:40.
    changes = [f"profiles.wheel_{number}=cone_1_40" for number in (1, 2)]
    geometry = geometry_of("undamaged", *changes, "profiles.inclination=0.025", "profiles.gauge=1.435")
    assert geometry.touch(1) == pytest.approx(0.0, abs=2e-5)


def test_to_the_left_is_towards_the_flange_of_wheel_2():
    middle, left = (geometry_of("lateral_offset", f"lateral_offset={offset}") for offset in (0.0, 0.003))
    for geometry in (middle, left):
        touched = [geometry.touch(wheel) - geometry.rolling_circle(wheel) for wheel in (0, 1)]
        assert touched[0] == pytest.approx(-0.0031 if geometry is middle else -0.0102, abs=5e-4)
        assert touched[1] == pytest.approx(0.0031 if geometry is middle else -0.0125, abs=5e-4)
    assert left.rolling_circle(0) - middle.rolling_circle(0) == pytest.approx(0.003)
    assert left.rolling_circle(1) - middle.rolling_circle(1) == pytest.approx(0.003)
    wheelset = load_scenario("lateral_offset").touched_wheelset
    assert wheelset.contact_positions[0] == pytest.approx(-0.7602, abs=5e-4)
    assert wheelset.contact_positions[1] == pytest.approx(0.7375, abs=5e-4)


def test_a_cylinder_that_is_moved_takes_its_defects_along():
    defect = Breakout("wheel_1", 0.02, 0.012, 0.0008, y=-0.002)
    moved = law_of(geometry_of("undamaged", "lateral_offset=0.005"), [defect])
    placed = law_of(geometry_of(), [dataclasses.replace(defect, y=0.003)])
    np.testing.assert_allclose(total_separation(moved, 0, 0, 0), total_separation(placed, 0, 0, 0), atol=1e-15)


@pytest.mark.slow
def test_mirrored_wheelsets_have_mirrored_contacts():
    defect = Breakout("wheel_1", 0.02, 0.012, 0.0008, y=-0.004)
    one = law_of(geometry_of("worn_profiles", "lateral_offset=0.002"), [defect])
    changes = ["lateral_offset=-0.002", "profiles.wheel_1=s1002", "profiles.wheel_2=s1002_hollow"]
    other = law_of(geometry_of("worn_profiles", *changes), [dataclasses.replace(defect, on="wheel_2", y=0.004)])
    for wheel in (0, 1):
        assert (one.y[wheel] == -other.y[1 - wheel, ::-1]).all()
        for tread in (-20, 0, 9, 1000):
            mine, mirrored = total_separation(one, wheel, tread, 0), total_separation(other, 1 - wheel, tread, 0)
            assert (mine == mirrored[:, ::-1]).all()
            forces = [contact_force(law, at, tread, 0, 2.5e-4, 1e-10) for law, at in ((one, wheel), (other, 1 - wheel))]
            assert forces[0] == pytest.approx(forces[1], rel=1e-9)
            assert forces[0] > 50e3


def parabola(bend):
    y = range(-30, 31)
    return f"{{y: {[1e-3 * each for each in y]}, z: {[round(bend * each**2, 9) for each in y]}}}"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["profiles.wheel_1=s1003"], r"profiles\.wheel_1: .* did you mean s1002"),
        (["profiles.rail_2=head"], r"profiles\.rail_2: .* did you mean head_60e1"),
        (["profiles.wheel_1=60e1"], r"profiles\.wheel_1: '600.0' is not a known profile"),
        (["profiles.wheel_3=s1002"], r"profiles\.wheel_3 is not a known key"),
        (["profiles.inclination=1"], r"profiles\.inclination = 1 is out of range"),
        (["profiles.gauge=1435"], r"profiles\.gauge = 1435 m is out of range"),
        (["profiles.gauge=.nan"], r"profiles\.gauge"),
        (["lateral_offset=0.1"], r"lateral_offset = 0\.1 m is out of range: give the distance"),
        (["profiles.wheel_1={y: [0, 1], z: [0, 1]}"], r"profiles\.wheel_1: a profile of 2 y and 2 z"),
        ([f"profiles.rail_1={parabola(1e-6)}"], r"profiles\.rail_1: z rises from the middle"),
        (
            [f"profiles.rail_1={parabola(-1e-6)}", "profiles.gauge=1.435"],
            r"rail_1: .* ends 0\.000899 m below its top, and the",
        ),
    ],
)
def test_what_cannot_be_used_is_refused_by_name(changes, words):
    with pytest.raises(InputError, match=words) as refusal:
        geometry_of("undamaged", *changes)
    assert "\n" not in str(refusal.value)


def test_flange_contact_is_refused():
    with pytest.raises(InputError, match=r"wheel_2 touches its rail at an angle of 0\.\d\d rad.*lateral_offset"):
        geometry_of("lateral_offset", "lateral_offset=0.006")
    with pytest.raises(InputError, match=r"wheel_1 touches its rail at an angle"):
        geometry_of("lateral_offset", "lateral_offset=-0.006")


def test_a_wheel_beside_its_rail_is_refused_with_what_puts_it_there():
    with pytest.raises(
        InputError, match=r"wheel_1 is 0\.211 m outside the middle of its rail, beside the head: .*gauge"
    ):
        geometry_of("lateral_offset", "profiles.gauge=1.0")


@pytest.mark.parametrize(
    ("spacing", "step", "words"), [(0.6, 7e-4, "give 0.000625 m"), (0.65, 9e-4, "give 0.0008125 m")]
)
def test_a_step_that_does_not_divide_the_bay_is_refused_with_one_that_does(spacing, step, words):
    changes = [f"track.spacing={spacing}"]
    with pytest.raises(InputError, match=f"does not divide the sleeper spacing of {spacing} m: {words}"):
        load_scenario("undamaged", [*changes, f"step_length={step}"])
    assert load_scenario("undamaged", [*changes, f"step_length={words.split()[1]}"])


def test_points_that_end_in_the_contact_area_are_refused():
    y = [round(1e-3 * k, 6) for k in range(-26, 27)]
    flat = read_profile("wheel", {"y": y, "z": [0.0] * len(y)}, "wheel_2")
    scenario = dataclasses.replace(load_scenario("undamaged"), profiles=Profiles(wheel_2=flat))
    with pytest.raises(InputError, match="points of wheel_2 or its rail end where the surfaces are"):
        dataclasses.replace(scenario, irregularities=(Breakout("wheel_1", 0.03, 0.024, 0.008),))


@pytest.mark.slow
def test_a_contact_at_the_largest_force_lies_in_the_area():
    for name, offset in (("lateral_offset", 0.003), ("worn_profiles", -0.002), ("worn_profiles", 0.002)):
        law = law_of(geometry_of(name, f"lateral_offset={offset}"))
        for wheel in (0, 1):
            assert force_at(law, wheel, 0, 0, approach_for_force(law, wheel, 0, 0, 599e3)) == pytest.approx(599e3)


def test_defects_change_live_on_worn_profiles():
    scenario = load_scenario("worn_profiles")
    simulator = Simulator(dataclasses.replace(scenario, irregularities=()))
    before = simulator.advance(2713).forces
    # New wheel or hollow one, each carries half of the load; smooth, forces vary by the sleepers alone.
    np.testing.assert_allclose(before.mean(axis=0), scenario.wheel_load, rtol=5e-3)
    assert np.ptp(before, axis=0).max() < 0.15 * scenario.wheel_load
    revision = simulator.apply(scenario)
    after = np.concatenate([simulator.advance(2713).forces for _ in range(3)])
    assert revision.number == 1
    assert after[:, 0].max() > 1.3 * scenario.wheel_load
    with pytest.raises(InputError, match="lateral_offset cannot change during a run"):
        simulator.apply(dataclasses.replace(scenario, lateral_offset=0.001))
    with pytest.raises(InputError, match="profiles cannot change during a run"):
        simulator.apply(dataclasses.replace(scenario, profiles=Profiles()))
