"""Every kind of irregularity: shapes by their formulas, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.schema import plain
from wheelset_track_sim.inputs.yaml12 import dump
from wheelset_track_sim.irregularities import (
    Breakout,
    Cluster,
    Corrugation,
    DippedWeld,
    Flat,
    Harmonic,
    HeadDefect,
    Joint,
    LogNormal,
    Polygon,
    Squat,
    Uniform,
    breakouts,
    rail_heights,
    tread_heights,
)
from wheelset_track_sim.irregularities.kinds import OWN
from wheelset_track_sim.irregularities.listing import listed
from wheelset_track_sim.scenario import load_scenario, scenario_from

N_C, DX = 2713, 1e-3
RADIUS = N_C * DX / (2 * math.pi)
Y = np.arange(-10, 11) * 1e-3
KINDS = OWN


@pytest.fixture(scope="module")
def entries():
    """One entry of each kind, from the shipped scenarios."""
    found = {}
    for name in shipped.names("scenarios"):
        for entry in load_scenario(name).to_mapping()["irregularities"]:
            found.setdefault(entry["type"], entry)
    return found


@pytest.mark.slow
def test_every_kind_has_a_shipped_scenario(entries):
    assert set(entries) == set(KINDS)


def scenario_with(*entries):
    return scenario_from({"name": "x", "speed": 25.0, "axle_load": 2e5, "irregularities": list(entries)})


NUMBERS = [
    (kind, field)
    for kind, owner in KINDS.items()
    for field in dataclasses.fields(owner)
    if "quantity" in field.metadata
]


@pytest.mark.parametrize(("kind", "field"), NUMBERS, ids=[f"{kind}.{field.name}" for kind, field in NUMBERS])
@given(data=st.data())
@pytest.mark.slow
def test_every_bad_number_is_refused_by_name(entries, kind, field, data):
    name, quantity = field.name, field.metadata["quantity"]
    span = quantity.high - quantity.low
    missing = [] if field.default is None else [None]
    value = data.draw(
        st.one_of(
            st.floats(quantity.high + 1e-3 * span, 1e300),
            st.floats(-1e300, quantity.low - 1e-3 * span),
            st.sampled_from([math.nan, math.inf, -math.inf, True, "three", "3 candela", [1.0], *missing]),
        )
    )
    with pytest.raises(InputError) as refusal:
        scenario_with({**entries[kind], name: value})
    assert str(refusal.value).startswith(f"irregularities.0.{name}")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("kind", KINDS)
def test_unknown_keys_and_surfaces_are_refused_with_those_that_are_known(entries, kind):
    entry = entries[kind]
    with pytest.raises(InputError, match=r"irregularities\.0\.colour is not a known key: .*known are on,"):
        scenario_with({**entry, "colour": 1})
    with pytest.raises(InputError, match=r"irregularities\.0\.on = 'wheel_3' is not a known choice"):
        scenario_with({**entry, "on": "wheel_3"})
    other = {"wheel_1": "rail_1", "rail_1": "wheel_1"}[entry["on"].replace("_2", "_1")]
    if kind not in ("roughness", "profile"):
        with pytest.raises(InputError, match=rf"irregularities\.0\.on = '{other}' is not a known choice"):
            scenario_with({**entry, "on": other})


def test_an_unknown_type_is_refused_with_the_list():
    with pytest.raises(InputError, match=r"irregularities\.0\.type = 'flatt' is not a known type: did you mean flat\?"):
        scenario_with({"type": "flatt", "on": "wheel_1"})
    with pytest.raises(InputError, match=r"irregularities\.0\.type is missing: known are breakout, cluster, flat"):
        scenario_with({"on": "wheel_1"})


@pytest.mark.parametrize("kind", KINDS)
def test_each_comes_back_from_its_own_text_and_over_a_network(entries, kind):
    scenario = scenario_with(entries[kind])
    again = listed(dump([plain(each) for each in scenario.irregularities]), lambda name: name)
    assert again == scenario.irregularities


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{}{}", "not YAML"),
        ("3", "irregularities are a int: give a list"),
        ("[3]", r"irregularities\.0 = 3"),
        ("[&a {type: flat}, *a]", "holds an alias"),
        ("[" * 100, "nested more than 20 times"),
        ("[" + "1," * 1001 + "]", "has 1001 entries: give at most 1000"),
        ("x" * 300_000, "300000 bytes"),
    ],
)
def test_texts_that_are_no_lists_are_refused(text, words):
    with pytest.raises(InputError, match=words):
        listed(text, lambda name: name)
    assert listed("", str) == listed("[]", str) == ()


def test_a_flat_is_as_deep_as_its_chord():
    fresh, worn = Flat("wheel_1", 0.060), Flat("wheel_1", 0.060, worn_length=0.120)
    assert fresh.depth(RADIUS) == worn.depth(RADIUS) == pytest.approx(0.060**2 / (8 * RADIUS), rel=2e-3)
    s = np.linspace(-0.029, 0.029, 59)
    # On the chord the distance from the line through its ends is none: R - sqrt(R^2 - s^2) lies as far below the tread.
    sunk = fresh.height(s, RADIUS) - (RADIUS - np.sqrt(RADIUS**2 - s**2))
    assert np.ptp(sunk) < 1e-15
    assert not fresh.height(np.array([-0.031, 0.031]), RADIUS).any()
    assert worn.height(np.array([0.0, 0.030, 0.060]), RADIUS) == pytest.approx(
        [-worn.depth(RADIUS), -worn.depth(RADIUS) / 2, 0]
    )
    with pytest.raises(InputError, match=r"worn_length = 0\.05 m is less than the fresh length of 0\.06 m"):
        dataclasses.replace(worn, worn_length=0.050)


def test_a_polygon_is_its_harmonics():
    polygon = Polygon("wheel_2", (Harmonic(1, 1e-4), Harmonic(18, 2e-5, phase=0.7)))
    heights = tread_heights([polygon], "wheel_2", N_C, DX, Y)
    assert (heights == heights[:, :1]).all()
    waves = 2 / N_C * np.fft.rfft(heights[:, 0])
    assert waves[[1, 18]] == pytest.approx([1e-4, 2e-5 * np.exp(0.7j)], abs=1e-12)
    assert np.abs(np.delete(waves, [1, 18])).max() < 1e-12
    with pytest.raises(InputError, match="order = 300 has waves shorter than two steps: give up to 135"):
        tread_heights([Polygon("wheel_1", (Harmonic(300, 1e-6),))], "wheel_1", 271, 0.01, Y)
    with pytest.raises(InputError, match="harmonics has 0 entries"):
        Polygon("wheel_1", ())


def test_a_cluster_is_drawn_from_its_distributions():
    cluster = Cluster(
        "wheel_1",
        a=LogNormal(0.006, 0.4),
        b=Uniform(0.004, 0.008),
        h=0.0003,
        angle=Uniform(1.0, 2.0),
        number=400,
        seed=3,
    )
    drawn = cluster.breakouts
    assert len(drawn) == 400
    assert dataclasses.replace(cluster).breakouts == drawn != dataclasses.replace(cluster, seed=4).breakouts
    assert np.log([each.a / 0.006 for each in drawn]).std() == pytest.approx(0.4, rel=0.12)
    assert np.median([each.a for each in drawn]) == pytest.approx(0.006, rel=0.08)
    assert {each.h for each in drawn} == {0.0003}
    for name, low, high in (("angle", 1.0, 2.0), ("b", 0.004, 0.008)):
        values = [getattr(each, name) for each in drawn]
        assert low <= min(values) < low + 0.02 * (high - low) < high - 0.02 * (high - low) < max(values) <= high
    one_by_one = tread_heights(drawn, "wheel_1", N_C, DX, Y)
    assert (tread_heights([cluster], "wheel_1", N_C, DX, Y) == one_by_one).all()
    assert [*breakouts([cluster, Breakout("wheel_2", 0.01, 0.01, 1e-4)])][:-1] == [*drawn]
    with pytest.raises(InputError, match=r"none of 1000 random draws is a valid breakout; the last one: a = 3 m"):
        dataclasses.replace(cluster, a=Uniform(3.0, 3.0))
    with pytest.raises(InputError, match=r"h = 1 m is out of range"):
        dataclasses.replace(cluster, h=1.0)
    with pytest.raises(InputError, match="high = 1 is below low = 2"):
        Uniform(2.0, 1.0)


def on_rail(shape, position=None):
    heights = rail_heights([shape], "rail_1", 12_000, DX, Y).all()
    return heights if position is None else heights[round(position / DX) + np.arange(-600, 601)]


def test_joints_meet_at_their_angle_and_welds_are_a_wave():
    joint = Joint("rail_1", position=3.0, dip_angle=0.010, length=1.0, gap=0.0)
    heights = on_rail(joint, 3.0)[:, 0]
    assert heights.min() == heights[600] == pytest.approx(-joint.depth) == -0.010 / 8
    kink = (heights[601] - heights[600]) / DX + (heights[599] - heights[600]) / DX
    assert kink == pytest.approx(0.010, rel=0.003)
    open_ends = on_rail(dataclasses.replace(joint, gap=0.006), 3.0)[:, 0] - heights
    assert np.flatnonzero(open_ends).tolist() == [598, 599, 600, 601, 602]
    weld = on_rail(DippedWeld("rail_1", 3.0, depth=0.0005, length=1.0), 3.0)[:, 0]
    s = np.arange(-600, 601) * DX
    assert weld == pytest.approx(np.where(np.abs(s) < 0.5, -0.00025 * (1 + np.cos(2 * np.pi * s)), 0.0), abs=1e-18)


def test_a_squat_has_two_lobes_and_a_head_defect_one():
    defect = HeadDefect("rail_1", position=2.0, a=0.020, b=0.008, h=0.0006, y=0.002)
    squat = Squat("rail_1", position=2.0, a=0.020, b=0.008, h=0.0006, y=0.002, ridge=0.5)
    one, two = on_rail(defect, 2.0), on_rail(squat, 2.0)
    assert one.min() == one[600, 12] == -0.0006
    assert two[600, 12] == pytest.approx(-0.0003)
    deepest = int(two[:, 12].argmin())
    assert 0.003 < abs(deepest - 600) * DX < 0.012
    assert two[deepest, 12] < -0.0003
    assert (two == two[::-1]).all()
    assert (dataclasses.replace(squat, ridge=0.0).height(0.003, 0.001) == defect.height(0.003, 0.001)).all()


def test_corrugation_stands_on_its_stretch_or_all_along():
    part = Corrugation("rail_1", wavelength=0.040, amplitude=1e-5, start=2.0, length=4.0, ramp=0.5)
    heights = on_rail(part)
    assert not heights[:2000].any()
    assert not heights[6001:].any()
    middle = np.arange(2500, 5501)
    assert heights[middle, 0] == pytest.approx(1e-5 * np.cos(2 * np.pi * (middle * DX - 2.0) / 0.040), abs=1e-13)
    assert (heights[2540] == heights[2500]).all()  # to the last bit
    along = on_rail(Corrugation("rail_1", wavelength=0.047, amplitude=1e-5))[:, 0]
    waves = np.abs(np.fft.rfft(along))
    assert waves.argmax() == round(12.0 / 0.047)
    assert np.sort(waves)[-2] < 1e-6 * waves.max()
    with pytest.raises(InputError, match=r"ramp = 3 m at both ends is more than length = 4 m"):
        dataclasses.replace(part, ramp=3.0)
    with pytest.raises(InputError, match=r"start = 2 m needs a length: give the length of the stretch, or leave start"):
        dataclasses.replace(part, length=None)


def test_overrides_reach_into_each_kind():
    changed = load_scenario("flat_fresh", ["irregularities.0.length=0.05"]).irregularities[0]
    assert changed.length == 0.05
    polygon = load_scenario("polygon", ["irregularities.0.harmonics.1.amplitude=3e-5"]).irregularities[0]
    assert polygon.harmonics[1].amplitude == 3e-5
    cluster = load_scenario("rcf_cluster", ["irregularities.0.a.median=0.004"]).irregularities[0]
    assert cluster.a.median == 0.004


def test_files_that_a_text_names_are_located_unless_their_content_is_there(tmp_path):
    (tmp_path / "spectrum.csv").write_text("wavelength [m],level\n0.4,17\n0.005,-10\n")
    text = "[{type: roughness, on: rail_1, file: spectrum.csv}]"
    asked = []

    def located(name):
        asked.append(name)
        return str(tmp_path / name)

    [rough] = listed(text, located)
    assert asked == ["spectrum.csv"]
    assert rough.spectrum == ((0.4, 17.0), (0.005, -10.0))
    (tmp_path / "spectrum.csv").unlink()
    assert listed(dump([plain(rough)]), located) == (rough,)
    assert asked == ["spectrum.csv"]
