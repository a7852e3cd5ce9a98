import dataclasses
import typing
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.contact.named_profiles import read_profile
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.yaml12 import dump, parse
from wheelset_track_sim.scenario import Loads, Profiles, Scenario, SetPoint, load_scenario, override, scenario_from
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.vehicle import Vehicle, load_vehicle


@pytest.mark.parametrize("name", shipped.names("scenarios"))
@pytest.mark.slow
def test_shipped_scenarios_load_and_come_back_from_their_own_text(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario_from(parse(scenario.to_yaml(), name)) == scenario


@pytest.mark.slow
def test_the_papers_load_cases_are_shipped() -> None:
    on = {name: sorted(item.on for item in load_scenario(name).irregularities) for name in shipped.names("scenarios")}
    assert on["undamaged"] == []
    assert on["damage_wheel_1"] == ["wheel_1"]
    assert on["damage_wheel_2"] == ["wheel_2"]
    assert on["damage_both"] == ["wheel_1", "wheel_2"]


def test_overrides_reach_into_lists() -> None:
    scenario = load_scenario("damage_wheel_1", ["irregularities.0.h=3e-4", "speed=30"])
    assert scenario.irregularities[0].h == 3e-4
    assert scenario.speed == 30.0


def test_speed_plans_are_lists_like_others() -> None:
    scenario = load_scenario("line_speeds", ["speed_plan.1.speed=20", "speed_plan.0.time=5"])
    assert [(point.time, point.speed) for point in scenario.speed_plan] == [(5.0, 61.1111111), (125.0, 20.0)]
    assert load_scenario("undamaged", ["speed_plan=[{time: 3, speed: 20}]"]).speed_plan == (SetPoint(3.0, 20.0),)
    with pytest.raises(InputError, match="speed = 3 m/s"):
        SetPoint(0.0, 3.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("speed=.nan", ["speed", "not finite"]),
        ("speed=nan", ["speed", "'nan' is not a number"]),
        ("speed=-3", ["speed = -3 m/s", "from 5 to 100 m/s"]),
        ("speed=fast", ["speed", "not a number"]),
        ("axle_load=1e9", ["axle_load", "from 20000 to 400000 N"]),
        ("irregularities.0.h=0.5", ["irregularities.0.h = 0.5 m"]),
        ("irregularities.0.b=0.2", ["irregularities.0.b"]),
        ("irregularities.0.y=0.045", ["irregularities.0", "beyond the tread"]),
        ("irregularities.0.on=wheel_3", ["irregularities.0.on", "wheel_3"]),
        ("irregularities.0.type=crater", ["irregularities.0.type", "breakout"]),
        ("irregularities.1.h=0.001", ["irregularities.1", "not an index"]),
        ("speeed=30", ["speeed", "did you mean speed"]),
        ("speed.now=30", ["speed"]),
        ("speed", ["key=value"]),
        ("name=", ["name"]),
        ("acceleration=0", ["acceleration = 0 m/s^2", "from 0.01 to 10 m/s^2"]),
        ("acceleration=.inf", ["acceleration", "not finite"]),
        ("name=3", ["name = 3", "give a text"]),
        ("speed_plan=30", ["speed_plan", "not a list: put its entries in brackets"]),
        ("speed_plan=[{time: 1}]", ["speed_plan.0.speed is missing"]),
        ("speed_plan=[{time: 1, speed: 300}]", ["speed_plan.0.speed = 300 m/s", "from 5 to 100 m/s"]),
        ("speed_plan=[{time: -1, speed: 30}]", ["speed_plan.0.time = -1 s"]),
        ("speed_plan=[{time: .nan, speed: 30}]", ["speed_plan.0.time", "not finite"]),
        ("speed_plan=[{time: 2, speed: 30}, {time: 2, speed: 20}]", ["speed_plan.1.time = 2 s", "increase"]),
    ],
)
def test_bad_changes_are_refused_by_name(change: str, words: list[str]) -> None:
    with pytest.raises(InputError) as refusal:
        load_scenario("damage_wheel_1", [change])
    assert "\n" not in str(refusal.value)
    for word in words:
        assert word in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("speed: [", "not YAML"),
        ("- 1", "not a mapping"),
        ("name: x", "speed is missing"),
        ("\x00", "is not text"),
        ("speed: 30\nspeed: 40\n", r"case.yaml, line 2: .*\"speed\".*: give it once$"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        load_scenario(path)


def test_missing_files_and_unknown_names_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        load_scenario(tmp_path / "none.yaml")
    with pytest.raises(InputError, match="did you mean damage_wheel_1"):
        load_scenario("damage_whel_1")


def test_digest_tells_scenarios_apart() -> None:
    scenario = load_scenario("damage_wheel_1")
    assert scenario.digest == load_scenario("damage_wheel_1").digest
    assert scenario.digest != dataclasses.replace(scenario, speed=scenario.speed + 1e-12).digest


@given(st.text(max_size=20), st.text(max_size=20))
def test_an_override_sets_or_refuses_and_nothing_else(key: str, value: str) -> None:
    data = {"name": "n", "speed": 30.0, "axle_load": 2e5, "irregularities": []}
    with suppress(InputError):
        override(data, f"{key}={value}")
        assert isinstance(scenario_from(data), Scenario)


@pytest.mark.parametrize("named", [True, False])
def test_a_key_within_a_shipped_model_makes_its_content_part_of_the_scenario(tmp_path: Path, named: bool) -> None:
    text = "name: plain\nspeed: 30.0\naxle_load: 196200.0\n"
    (tmp_path / "plain.yaml").write_text(text + ("track: ballasted_60e1\nwheelset: x40\n" if named else ""))
    scenario = load_scenario(tmp_path / "plain.yaml", ["track.pad.stiffness=9e7", "wheelset.wheel.rolling_radius=0.42"])
    assert scenario.track == dataclasses.replace(
        load_track("ballasted_60e1"), pad=dataclasses.replace(load_track("ballasted_60e1").pad, stiffness=9e7)
    )
    assert (scenario.wheelset.rolling_radius, scenario.wheelset.name) == (0.42, "x40")
    assert scenario.steps_per_revolution == round(2 * np.pi * 420)
    assert scenario_from(parse(scenario.to_yaml(), "")) == scenario


def test_shipped_models_are_names_in_text_and_others_their_content() -> None:
    mapping = load_scenario("undamaged").to_mapping()
    assert (mapping["wheelset"], mapping["track"]) == ("x40", "ballasted_60e1")
    assert mapping["profiles"]["wheel_1"] == "cylinder"
    mapping = load_scenario("undamaged", ["track.sleeper.length=2.6"]).to_mapping()
    assert (mapping["wheelset"], mapping["track"]["sleeper"]["length"]) == ("x40", 2.6)
    for kind in ("wheelsets", "tracks"):
        for name in shipped.names(kind):
            assert load_scenario("undamaged", [f"{kind[:-1]}={name}", NODES[name]]).to_mapping()[kind[:-1]] == name


NODES = dict.fromkeys(["trailer", "trailer_calculix", "freight", "metro"], "output.stress_nodes=[A1]")
NODES |= dict.fromkeys(["slab_60e1", "ballasted_54e1", "ballasted_60e1", "x40"], "speed=30")


def test_a_vehicle_is_a_name_its_content_or_none(tmp_path: Path) -> None:
    assert load_scenario("undamaged").vehicle is None
    named = load_scenario("undamaged", ["vehicle=power_car"])
    assert (named.vehicle, named.to_mapping()["vehicle"]) == (load_vehicle("power_car"), "power_car")
    heavier = load_scenario("undamaged", ["vehicle=power_car", "vehicle.bogie_mass=2000"])
    assert heavier.vehicle == dataclasses.replace(load_vehicle("power_car"), bogie_mass=2000.0)
    own = ["vehicle.bogie_mass=900", "vehicle.secondary_stiffness=3e5", "vehicle.secondary_damping=1e4"]
    plain = load_scenario("undamaged", own)
    assert plain.vehicle == Vehicle(900.0, 3e5, 1e4)
    for scenario in (named, heavier, plain):
        assert scenario_from(parse(scenario.to_yaml(), "")) == scenario
    (tmp_path / "mine.yaml").write_text(dump(plain.to_mapping()["vehicle"]))
    assert load_scenario("undamaged", [f"vehicle={tmp_path}/mine.yaml"]).vehicle == plain.vehicle


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("vehicle=tram", r"^vehicle = 'tram' is not a known vehicle: .*known are coach, power_car"),
        ("vehicle.bogie_mass=900", r"^vehicle\.secondary_stiffness is missing"),
        (
            "vehicle={bogie_mass: 1, secondary_stiffness: 3e5, secondary_damping: 0}",
            r"^vehicle\.bogie_mass = 1 kg is out",
        ),
        (
            "vehicle={bogie_mass: 900, secondary_stiffness: 3e5, secondary_damping: 0, body_mass: 5}",
            r"body_mass = 5 kg",
        ),
    ],
)
def test_a_vehicle_that_cannot_be_is_refused(change: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario("undamaged", [change])


def test_a_car_body_is_slower_than_the_functions_of_paper_dynamics() -> None:
    changes = ["vehicle=coach", "vehicle.body_mass=4000", "dynamics=paper"]
    with pytest.raises(InputError, match=r"^vehicle\.body_mass moves too slowly for .* leave it out"):
        load_scenario("undamaged", changes)


def test_imported_wheelsets_come_back_from_their_own_text() -> None:
    shown = load_scenario("imported")
    wheelset = dataclasses.replace(shown.wheelset, name="mine")
    scenario = dataclasses.replace(shown, wheelset=wheelset)
    assert scenario.to_mapping()["wheelset"]["name"] == "mine"
    assert scenario_from(parse(scenario.to_yaml(), "")) == scenario


def test_files_of_models_become_part_of_the_scenario(tmp_path: Path) -> None:
    """A bag that holds the scenario then needs no file."""
    track = tmp_path / "soft.yaml"
    content = shipped.load_yaml("tracks", "ballasted_60e1") | {"name": "soft"}
    track.write_text(dump(content))
    scenario = load_scenario("undamaged", [f"track={track}"])
    track.unlink()
    assert scenario.track == load_track(content)
    assert scenario_from(parse(scenario.to_yaml(), "")) == scenario
    with pytest.raises(InputError, match=r"soft\.yaml cannot be read"):
        load_scenario("undamaged", [f"track={track}"])


def test_a_mapping_opens_no_file(tmp_path: Path) -> None:
    """What comes from a bag or over a network is a mapping: it may name shipped models alone."""
    data = load_scenario("undamaged").to_mapping()
    track = tmp_path / "soft.yaml"
    track.write_text(dump(shipped.load_yaml("tracks", "ballasted_60e1")))
    for key in ("track", "wheelset"):
        with pytest.raises(InputError, match=rf"^{key} = '.*soft.yaml' is not a known {key}"):
            scenario_from(data | {key: str(track)})


def test_files_are_found_beside_the_scenario_that_names_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "axle.yaml").write_text(dump(shipped.load_yaml("wheelsets", "trailer")))
    (tmp_path / "mine" / "soft.yaml").write_text("base: ballasted_60e1\npad: {stiffness: 9.0e+7}\n")
    (tmp_path / "mine" / "worn.csv").write_text(shipped.file("wheel_profiles", "s1002_hollow.csv").read_text())
    text = "name: mine\nspeed: 30.0\naxle_load: 137340.0\nwheelset: axle.yaml\n"
    text += "profiles: {wheel_1: worn.csv, wheel_2: s1002, inclination: 0.025, gauge: 1.435}\n"
    text += "output: {stress_nodes: [A1]}\n"
    (tmp_path / "mine" / "case.yaml").write_text(text + "track: soft.yaml\n")
    (tmp_path / "mine" / "wide.yaml").write_text(text + "track: {base: soft.yaml, spacing: 0.65}\n")
    monkeypatch.chdir(tmp_path)
    case, wide = load_scenario("mine/case.yaml"), load_scenario("mine/wide.yaml")
    for file in ("axle.yaml", "soft.yaml", "worn.csv"):
        (tmp_path / "mine" / file).unlink()
    assert case.track.pad.stiffness == wide.track.pad.stiffness == 9e7
    assert wide.track.spacing == 0.65
    assert case.wheelset == wide.wheelset == load_wheelset("trailer")
    assert case.profiles.wheel_1 == read_profile("wheel", "s1002_hollow", "")
    assert scenario_from(parse(wide.to_yaml(), "")) == wide


@pytest.mark.parametrize("suffix", [".txt", ".YAML", "", ".conf"])
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_files_of_models_may_have_any_suffix_and_encoding(tmp_path: Path, suffix: str, encoding: str) -> None:
    """F12: a file that exists was called an unknown name."""
    for kind, name in (("wheelsets", "trailer"), ("tracks", "slab_60e1"), ("scenarios", "trailer")):
        (tmp_path / f"{kind}{suffix}").write_text(dump(shipped.load_yaml(kind, name)), encoding=encoding)
    changes = [f"wheelset={tmp_path}/wheelsets{suffix}", f"track={tmp_path}/tracks{suffix}"]
    case = load_scenario(tmp_path / f"scenarios{suffix}", changes)
    assert case.wheelset == load_wheelset("trailer")
    assert case.track == load_track("slab_60e1")


def test_files_that_are_based_on_themselves_come_to_an_end(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    own.write_text(f"base: {own}\n")
    with pytest.raises(InputError, match=r"track\.base = .*own\.yaml"):
        load_scenario("undamaged", [f"track={own}"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("output.stress_nodes=[A1, Z9]", ["output.stress_nodes.1 = 'Z9'", "known are A1, B1, C1"]),
        ("loads.torque_at=[gearbox, engine]", ["loads.torque_at.1 = 'engine'", "gearbox, wheel_1, wheel_2"]),
        ("loads.stresses=[{node: Q, xx: 1e6}]", ["loads.stresses.0.node = 'Q'"]),
        ("step_length=0.0007", ["step_length = 0.0007 m does not divide the sleeper spacing of 0.6 m", "give 0.0006"]),
        ("track.pad.stiffness=1", ["track.pad.stiffness = 1 N/m"]),
        ("track.name=[1]", ["track.name = [1]"]),
        ("wheelset.axle.sections.0.diameter=9", ["wheelset.axle.sections.0.diameter = 9 m"]),
        ("wheelset=x41", ["wheelset", "did you mean x40"]),
        ("profiles.wheel_1=s1003", ["profiles.wheel_1", "did you mean s1002"]),
        ("profiles.gauge=9", ["profiles.gauge = 9 m"]),
        ("profiles={wheel_1: s1002, wheel_2: s1002, gauge: 1.38}", ["wheel_1 "]),
        (
            "irregularities=[{type: flat, on: wheel_1, length: 0.06, worn_length: 0.05}]",
            ["irregularities.0", "worn_length"],
        ),
        ("irregularities=[{type: corrugation, on: rail_1, start: 59.0, length: 9000.0}]", ["irregularities.0"]),
        ("line_length=0.7123", ["line_length = 0.7123 m is not a whole number of steps"]),
    ],
)
def test_every_error_is_raised_when_a_scenario_is_loaded(change: str, words: list[str]) -> None:
    changes = ["loads.torque=1000", change] if "loads" in change else [change]
    with pytest.raises(InputError) as refusal:
        load_scenario("damage_wheel_1", changes)
    assert "\n" not in str(refusal.value)
    for word in words:
        assert word in str(refusal.value)


def test_no_public_field_of_a_scenario_is_untyped() -> None:
    hints = typing.get_type_hints(Scenario) | typing.get_type_hints(Profiles) | typing.get_type_hints(Loads)
    assert not [name for name, hint in hints.items() if "Any" in str(hint)]


@pytest.mark.parametrize("change", ["speed = 30", " speed=30", "speed= 30 ", "speed : 30"])
def test_spaces_around_a_key_and_its_value_do_not_count(change: str) -> None:
    if "=" in change:
        assert load_scenario("undamaged", [change]) == load_scenario("undamaged", ["speed=30"])
    else:
        with pytest.raises(InputError, match="--set 'speed : 30' is not of the form key=value, such as speed=30"):
            load_scenario("undamaged", [change])


def test_units_are_read_where_people_type_and_text_stays_si() -> None:
    changes = ["speed=100 km/h", "axle_load=22.5 t", "irregularities.0.h=1.5 mm", "irregularities.0.angle=90 deg"]
    changes += ["track.pad.stiffness=120 kN/mm", "track.pad.damping=25 kN s/m"]
    changes += ["speed_plan=[{time: 1 min, speed: 200 km/h}]"]
    scenario = load_scenario("damage_wheel_1", changes)
    (breakout,) = scenario.irregularities
    assert (scenario.speed, scenario.axle_load, breakout.h, breakout.angle) == (250 / 9, 220725.0, 0.0015, np.pi / 2)
    assert (scenario.track.pad.stiffness, scenario.track.pad.damping) == (120e6, 25e3)
    assert (scenario.speed_plan[0].time, scenario.speed_plan[0].speed) == (60.0, 500 / 9)
    assert scenario_from(parse(scenario.to_yaml(), "text")) == scenario
    assert not {"km/h", "mm", "deg"} & set(scenario.to_yaml().split())


def test_distributions_of_clusters_have_units() -> None:
    cluster = "{type: cluster, on: wheel_1, number: 3, a: {type: uniform, low: 5 mm, high: 1 cm}, b: 6 mm, h: 0.0002}"
    (found,) = load_scenario("undamaged", [f"irregularities=[{cluster}]"]).irregularities
    assert (found.a.low, found.a.high, found.b) == (0.005, 0.01, 0.006)


def test_a_number_that_looks_like_another_unit_is_reported() -> None:
    with pytest.warns(InputWarning, match=r"^speed = 100 is taken as 100 m/s \(360 km/h\), and looks like 100 km/h"):
        load_scenario("undamaged", ["speed=100"])
    load_scenario("undamaged", ["speed=100 m/s"])  # warnings are errors here
