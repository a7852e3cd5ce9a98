import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.dataset.labels import LINE_BAYS, group, labels
from wheelset_track_sim.dataset.spec import DatasetSpec, load_spec
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.schema import confirmed_numbers, plain, read

NAMED = {"title": "Mine", "licence": "CC0-1.0"}


def spec(**given):
    return read(DatasetSpec, NAMED | given, "")


@pytest.fixture(scope="module")
def plain_spec():
    return spec()


@pytest.mark.parametrize("name", shipped.names("datasets"))
def test_shipped_ones_can_be_written(name):
    assert len(list(labels(load_spec(name), 1, 40))) == 40


def test_roughness_joints_scatter_and_noise_are_on_by_default(plain_spec):
    first = group(plain_spec, 1, 0, 16)[0]
    assert np.isfinite([first.wheel_roughness, first.rail_roughness]).all()
    assert first.pad_scatter > 0
    assert first.ballast_scatter > 0
    assert any(np.isfinite(label.joint_position) for label in labels(plain_spec, 1, 128))
    assert all(sensor.noise > 0 for sensor in plain_spec.sensors)


def test_a_spec_read_from_its_plain_data_is_equal(plain_spec):
    with confirmed_numbers():
        assert read(DatasetSpec, plain(plain_spec), "") == plain_spec


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"licence": " "}, "licence is empty: give the licence of the data set"),
        ({"sped": 3}, "sped is not a known key: did you mean speed?"),
        ({"speed": "300 kN"}, "speed = '300 kN' is not in a unit of this quantity"),
        ({"speed": 300.0}, "speed = 300 m/s is out of range: give the running speed from 5 to 100 m/s"),
        (
            {"speed": {"distribution": "normal", "mean": 25, "deviation": 4}},
            "speed reaches -.* m/s, which is out of range: give its low and high from 5 to 100 m/s",
        ),
        ({"damage": []}, "damage has no kind with a weight above 0"),
        ({"damage": [{"type": "dent"}]}, "damage.0.type = 'dent' is not a known type: .*known are none, flat"),
        ({"damage": [{"type": "flat", "length": "1 m"}]}, "damage.0.length = 1 m, which is 1 m, is out of range"),
        ({"damage": [{"type": "breakout", "a": 0.1}]}, "damage.0: a breakout of the lateral semi-axis 0.09 m at y"),
        ({"duration": 0.05}, "duration = 0.05 s at 16.6667 m/s is less than a turn of 2.71 m"),
        ({"rate": 2e4}, "sensors.0.rate = 20000 Hz has a band above half the 16666.7 steps a second"),
        ({"sensors": [{"type": "strain_gauge", "name": "g", "rate": 5e3}]}, "sensors.0.rate = 5000 Hz is not the rate"),
        ({"sensors": [{"type": "strain_gauge", "name": "g", "y": 0.4}]}, "sensors.0: y = 0.4 m is under gearbox"),
        ({"scenario": "nothing"}, "'nothing' is not a known scenario"),
        ({"set": {"track.line": {"bays": 60}}}, "scenario.track.line has no place in a data set: leave it out"),
        ({"set": {"dynamics": "paper"}}, "sensors read the modes of causal dynamics"),
        ({"split": {"train": 0.9}}, r"split: train \+ validation \+ test = 1.2: give shares that add up to 1"),
        ({"detector": "shear"}, "detector = 'shear' is not a known detector"),
        ({"detector": "shear_array"}, "duration = 0.25 s at 16.6667 m/s is 4.17 m, and detector shear_array needs"),
        ({"pad_scatter": 2}, "pad_scatter = 2 is out of range: give the coefficient of variation"),
    ],
)
def test_refusals_are_one_line(given, reason):
    with pytest.raises(InputError, match=f"^{reason}") as refused:
        spec(**given)
    assert "\n" not in str(refused.value)


def test_labels_are_the_same_again_and_those_of_fewer_samples_are_the_first(plain_spec):
    text = [repr(label) for label in labels(plain_spec, 7, 70)]
    assert text == [repr(label) for label in labels(plain_spec, 7, 100)][:70]
    assert text != [repr(label) for label in labels(plain_spec, 8, 70)]


def test_a_wheelset_keeps_its_damage_and_its_part_in_all_passages(plain_spec):
    seen = {}
    for label in labels(plain_spec, 3, 640):
        kept = (label.damage, label.damaged_wheel, label.split, label.wheel_seed, repr(label.sizes))
        assert seen.setdefault(label.wheelset, kept) == kept
    assert len(seen) == 320


def test_shares_of_damage_and_parts_are_those_of_the_spec(plain_spec):
    found = list(labels(plain_spec, 5, 4000))
    sound = np.mean([label.damage == "none" for label in found])
    assert sound == pytest.approx(0.5, abs=0.04)
    parts = [np.mean([label.split == part for label in found]) for part in ("train", "validation", "test")]
    assert parts == pytest.approx([0.7, 0.15, 0.15], abs=0.02)


def test_damage_comes_in_where_it_is_off_the_rail_and_joints_are_on_the_line(plain_spec):
    turn, origin = plain_spec.base.steps_per_revolution, plain_spec.base.tread_origin
    for label in labels(plain_spec, 5, 400):
        if label.damaged_wheel:
            at = (round(label.angle / (2 * np.pi) * turn) + origin - label.start_step) % turn
            assert 200 < at < turn - 200
        assert not label.joint_position > LINE_BAYS * 0.6 - 0.5


def test_sizes_are_of_the_kind(plain_spec):
    for label in labels(plain_spec, 1, 200):
        known = {name for name, size in label.sizes.items() if np.isfinite(size)}
        assert (
            known
            == {
                "none": set(),
                "flat": {"length"},
                "worn_flat": {"length", "worn_length"},
                "breakout": {"a", "b", "h", "y"},
            }[label.damage]
        )


def test_nothing_is_rough_without_a_level(plain_spec):
    smooth = dataclasses.replace(plain_spec, wheel_roughness=None, rail_roughness=None)
    assert all(np.isnan([each.wheel_roughness, each.rail_roughness]).all() for each in labels(smooth, 1, 16))
