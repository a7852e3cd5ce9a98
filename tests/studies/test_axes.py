import dataclasses

import pytest

from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.studies import Study
from wheelset_track_sim.studies.axes import read_axis


def values(name, data):
    return [point.value for point in read_axis(name, data, f"vary.{name}").points]


def test_range_holds_both_ends_and_round_numbers() -> None:
    depths = values("irregularities.0.h", {"start": 0, "stop": 3, "step": 0.05, "unit": "mm"})
    assert len(depths) == 61
    assert depths[0] == 0.0
    assert depths[3] == 0.00015
    assert depths[40] == 0.002
    assert depths[-1] == 0.003


def test_values_are_read_in_si_and_shown_for_people() -> None:
    axis = read_axis("speed", {"values": [40, 100], "unit": "km/h"}, "vary.speed")
    assert [point.value for point in axis.points] == pytest.approx([40 / 3.6, 100 / 3.6])
    assert [point.label for point in axis.points] == ["40 km/h", "100 km/h"]
    assert (axis.meaning, axis.unit) == ("running speed", "m/s")
    load = read_axis("axle_load", {"values": [20], "unit": "t"}, "vary.axle_load")
    assert (load.points[0].value, load.points[0].label) == (196200.0, "196.2 kN")


def test_labels_change_several_keys() -> None:
    axis = read_axis("size", {"A": {"irregularities.0.a": 0.01, "irregularities.0.b": 0.008}}, "vary.size")
    assert axis.points[0].changes == (("irregularities.0.a", 0.01), ("irregularities.0.b", 0.008))
    assert axis.keys == {"irregularities.0.a", "irregularities.0.b"}
    assert not axis.is_numeric
    assert axis.point("A", "size").label == "A"


def test_texts_are_values_too() -> None:
    assert values("lag_zero", ["residual", "zero"]) == ["residual", "zero"]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({"start": 0, "stop": 1}, "vary.speed.step = None is not a number"),
        ({"start": 0, "stop": 1, "step": 0.3}, "vary.speed.stop = 1 is not a whole number of steps of 0.3"),
        ({"start": 1, "stop": 0, "step": 0.5}, "vary.speed from 1 to 0 by 0.5 is not a valid range"),
        ({"start": 0, "stop": 1, "step": 0}, "is not a valid range"),
        ({"start": 0, "stop": float("nan"), "step": 1}, "vary.speed.stop = nan is not a number"),
        ({"values": [1], "unit": "mph"}, "vary.speed.unit = 'mph' is not a known unit of this quantity"),
        ({"values": [1], "unit": "mm"}, "known are m/s, km/h"),
        ({"valves": [1]}, "vary.speed.valves is not a known key: did you mean values?"),
        ([30, 30.0], "vary.speed has 108 km/h more than once"),
        ([], "vary.speed = [] is not an axis"),
        (30, "vary.speed = 30 is not an axis"),
        ({}, "not a number"),
    ],
)
def test_refusals_name_the_axis(data, said: str) -> None:
    with pytest.raises(InputError) as refusal:
        read_axis("speed", data, "vary.speed")
    assert said in str(refusal.value)


def test_value_that_is_not_on_the_axis_is_refused() -> None:
    axis = read_axis("irregularities.0.h", [0.0003, 0.002], "vary.h")
    assert axis.point(0.3e-3, "at").label == "0.3 mm"
    with pytest.raises(InputError, match=r"at = 0.001 is not a known value: .*known are 0.0003, 0.002"):
        axis.point(0.001, "at")


def test_values_may_have_units_of_their_own() -> None:
    axis = read_axis("speed", ["40 km/h", 20, "100 km/h"], "vary.speed")
    assert [point.value for point in axis.points] == pytest.approx([40 / 3.6, 20, 100 / 3.6])
    assert axis.point("100 km/h", "at").label == "100 km/h"
    assert axis.point("20 m/s", "at").label == "72 km/h"
    depths = values("irregularities.0.h", {"start": 0, "stop": "1 mm", "step": "250 um"})
    assert depths == [0.0, 0.00025, 0.0005, 0.00075, 0.001]
    loads = values("axle_load", {"start": 10, "stop": "20 t", "step": 5, "unit": "t"})
    assert loads == [98100.0, 147150.0, 196200.0]
    with pytest.raises(InputError, match=r"vary.speed.1 = '2 mm' is not in a unit of this quantity"):
        values("speed", [20, "2 mm"])


def test_numbers_that_look_like_another_unit_are_reported_where_they_are_given() -> None:
    base = load_scenario("undamaged").to_mapping() | {"speed": "100 m/s"}
    study = Study(title="t", scenario=base, outputs=("wheels.wheel_1.max_force",), set={"axle_load": "30 kN"})
    assert study.runs()[0].scenario.speed == 100.0  # warnings are errors here
    sure = {"speed": ["80 m/s", "360 km/h"]}
    assert len(dataclasses.replace(study, vary=sure).runs()) == 2
    for where, vary in (
        ("vary.speed", {"speed": [90, 20]}),
        ("vary.case.fast.speed", {"case": {"fast": {"speed": 90}}}),
    ):
        with pytest.warns(InputWarning, match=f"^{where} = 90 is taken as 90 m/s"):
            dataclasses.replace(study, vary=vary)
    with pytest.warns(InputWarning, match=r"^--set axle_load = 22000 is taken as 22000 N .* looks like 22000 kg"):
        study.base(["axle_load=22000"])


def test_a_label_that_yaml_reads_as_a_number_is_refused() -> None:
    with pytest.raises(InputError, match=r"vary\.track has the label 540\.0, which YAML reads so: put it in quotes"):
        read_axis("track", {540.0: {"track": "ballasted_54e1"}}, "vary.track")
