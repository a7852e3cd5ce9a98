import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.written import forms
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.irregularities import Profile, rail_heights, tread_heights
from wheelset_track_sim.scenario import load_scenario

N_C, DX = 2713, 1e-3
Y = np.array([-0.004, 0.0, 0.003])


def csv(path, rows, header="angle,height"):
    path.write_text(
        "\n".join([header, *(",".join("" if np.isnan(x) else repr(float(x)) for x in row) for row in rows)])
    )
    return str(path)


def waves(angle, *orders):
    return sum(1e-5 * np.cos(order * angle + order) for order in orders)


def on_wheel(file, **options):
    return Profile("wheel_1", file, **{"along": "rad", "height": "m"} | options)


def heights_of(profile):
    return tread_heights([profile], profile.on, N_C, DX, Y)


@pytest.mark.parametrize("samples", [720, 2713, 6000])
def test_a_tread_comes_back_and_waves_that_steps_cannot_hold_do_not_appear_as_others(tmp_path, samples):
    angle = 2 * np.pi * np.arange(samples) / samples
    short = (2000,) if samples > 4000 else ()
    file = csv(tmp_path / "tread.csv", zip(angle, 0.43 + waves(angle, 1, 7, 90, *short), strict=True))
    found = heights_of(on_wheel(file))
    assert (found == found[:, :1]).all()
    steps = 2 * np.pi * np.arange(N_C) / N_C
    assert found[:, 0] == pytest.approx(waves(steps, 1, 7, 90), abs=1e-13)


def test_an_angle_turns_it_and_units_are_those_given(tmp_path):
    angle = np.arange(0.0, 360.0, 0.5)
    file = csv(tmp_path / "tread.csv", zip(angle, 1e3 * waves(np.radians(angle), 3), strict=True))
    profile = on_wheel(file, along="deg", height="mm")
    turned = dataclasses.replace(profile, angle=1.0)
    assert heights_of(turned) == pytest.approx(
        np.roll(heights_of(profile), round(N_C / (2 * np.pi)), axis=0), abs=1e-18
    )
    length = np.arange(2800) * 1.0  # mm around a wheel that is 3 % larger
    file = csv(tmp_path / "length.csv", zip(length, 1e6 * waves(2 * np.pi * length / 2800, 3), strict=True))
    assert heights_of(on_wheel(file, along="mm", height="um")) == pytest.approx(heights_of(profile), abs=1e-9)


@pytest.mark.parametrize("length", [1.4, 2713.0])
def test_a_length_that_is_no_turn_of_the_wheel_is_refused(tmp_path, length):
    along = length * np.arange(1000) / 1000
    profile = on_wheel(
        csv(tmp_path / "tread.csv", zip(along, waves(2 * np.pi * along / length, 1), strict=True)), along="m"
    )
    words = rf"tread.csv is {length:.4g} m long, and a turn of wheel_1 2.713 m: give one whole turn, within 20%"
    with pytest.raises(InputError, match=words):
        heights_of(profile)


def test_numpy_files_and_tables_across(tmp_path):
    angle, across = np.linspace(0, 2 * np.pi, 720, endpoint=False), np.array([-5.0, 0.0, 5.0])
    table = np.full((721, 4), np.nan)
    table[0, 1:], table[1:, 0] = across, angle
    table[1:, 1:] = waves(angle, 4)[:, None] * (1 + across / 10)
    np.save(tmp_path / "tread.npy", table)
    profile = on_wheel(str(tmp_path / "tread.npy"))
    expected = waves(2 * np.pi * np.arange(N_C) / N_C, 4)[:, None] * (1 + Y * 1e3 / 10)
    assert heights_of(profile) == pytest.approx(expected, abs=1e-13)
    text = csv(tmp_path / "tread.csv", table[1:], ",".join(["angle", *map(str, across)]))
    assert heights_of(on_wheel(text)) == pytest.approx(heights_of(profile), abs=1e-15)


ANGLE = np.arange(0.0, 360.0, 1.0)
TREADS = np.column_stack([ANGLE, 1e6 * waves(np.radians(ANGLE), 3), 1e6 * waves(np.radians(ANGLE), 7)]).round(4)


@given(form=forms())
def test_every_form_of_table_is_the_same_tread(tmp_path_factory, form):
    names, units = ("angle", "wheel_1", "wheel_2"), ("deg", "um", "um")
    path = form.write(tmp_path_factory.getbasetemp() / "tread.dat", names, units, TREADS.tolist())
    for number in (1, 2):
        profile = Profile(f"wheel_{number}", str(path))  # the unit and the column are in the headings
        assert (profile.along, profile.height) == ("deg", "um")
        assert np.array_equal(profile.samples.values[:, 0], TREADS[:, number] * 1e-6)


@pytest.mark.parametrize(
    ("heading", "options", "column"),
    [
        ("angle_deg,wheel_1_um,wheel_2_um", {}, 1),
        ("angle_deg,wheel_1_um,wheel_2_um", {"on": "wheel_2"}, 2),
        ("angle_deg,wheel_1_um,wheel_2_um", {"column": "wheel_2"}, 2),
        ("angle_deg,wheel_1_um,wheel_2_um", {"column": "wheel_2_um"}, 2),
        ("angle_deg,links_um,rechts_um", {"column": "rechts"}, 2),
        ("angle_deg,links_um,rechts_um", {"column": "2"}, 1),
        ("angle,links,rechts", {"column": "links", "along": "deg", "height": "um"}, 1),
        ("", {"column": "3", "along": "deg", "height": "um"}, 2),
        ("angle_deg,links_um,rechts_um", {}, r"has angle \[deg\], links \[um\], rechts \[um\]: give column"),
        ("angle,wheel_1,wheel_2", {}, "'angle' has no unit: give along: rad, deg, m or mm, or write it"),
        ("angle_deg,wheel_1,wheel_2", {}, "'wheel_1' has no unit: give height: m, mm or um"),
        ("angle_deg,wheel_1_um,wheel_2_um", {"height": "mm"}, r"'wheel_1 \[um\]' in um, but you gave mm"),
        ("angle_deg,wheel_1_um,wheel_2_um", {"along": "m"}, r"unit of 'angle \[deg\]' is not a unit of length"),
        ("angle_deg,wheel_1_kN,wheel_2_um", {}, r"unit of 'wheel_1 \[kN\]' is not a unit of length"),
        ("angle_deg,wheel_1_um,wheel_2_um", {"column": "wheel_3"}, "has no column 'wheel_3' for the heights"),
        (
            "angle_deg,wheel_1_um,wheel_2_um",
            {"column": "angle"},
            "holds the longitudinal positions: give the column of the heights",
        ),
        ("", {"along": "deg", "height": "um"}, "has column 1, column 2, column 3: give column"),
    ],
)
def test_named_columns_decide_and_what_is_not_named_is_asked_for(tmp_path, heading, options, column):
    """F2: angle, wheel_1, wheel_2 were read as a table over y."""
    path = tmp_path / "tread.csv"
    path.write_text("\n".join([heading, *(",".join(map(repr, row)) for row in TREADS.tolist())]))
    given = {"on": "wheel_1", "file": str(path)} | options
    if isinstance(column, str):
        with pytest.raises(InputError, match=column):
            Profile(**given)
    else:
        assert np.array_equal(Profile(**given).samples.values[:, 0], TREADS[:, column] * 1e-6)


def test_columns_named_by_positions_are_a_table_over_them(tmp_path):
    for name, corner in (("text.csv", "angle_deg,-5,0,5"), ("comma.csv", "angle_deg;-5,0;0,0;5,0")):
        mark = ";" if ";" in corner else ","
        rows = [mark.join([repr(a), repr(h), repr(2 * h), repr(3 * h)]) for a, h, _ in TREADS.tolist()]
        (tmp_path / name).write_text(
            "\n".join([corner, *(row.replace(".", ",") if mark == ";" else row for row in rows)])
        )
        found = Profile("wheel_1", str(tmp_path / name), height="um").samples
        assert found.across.tolist() == [-0.005, 0.0, 0.005]
        assert np.array_equal(found.values[:, 2], (3 * TREADS[:, 1]) * 1e-6)
        with pytest.raises(InputError, match="one column for each lateral position: give height: m, mm or um"):
            Profile("wheel_1", str(tmp_path / name))


def test_other_units_become_metres(tmp_path):
    (tmp_path / "rail.csv").write_text(
        "position [km],height [cm]\n" + "".join(f"{k / 1e6!r},{k % 7}\n" for k in range(50))
    )
    profile = Profile("rail_1", str(tmp_path / "rail.csv"), ramp=0.01)
    assert (profile.along, profile.height) == ("m", "m")
    np.testing.assert_allclose(profile.samples.along, np.arange(50) * 1e-3)
    np.testing.assert_allclose(profile.samples.values[:, 0], np.arange(50) % 7 * 1e-2)


def test_heights_in_another_unit_are_warned_of(tmp_path):
    with pytest.warns(InputWarning, match=r"has heights within 2e-08 m, smoother than any real surface: check height"):
        on_wheel(csv(tmp_path / "tread.csv", TREADS[:, :2] * [1.0, 1e-3]), along="deg", height="um")


def test_gaps_are_refused_or_filled_as_told(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    rows = np.column_stack([angle, waves(angle, 2)])
    missing = rows.copy()
    missing[100:105, 1] = np.nan
    cut = np.delete(rows, slice(300, 310), axis=0)
    whole = heights_of(on_wheel(csv(tmp_path / "whole.csv", rows)))
    for name, with_gap, words in (("missing", missing, "no value at 0.87"), ("cut", cut, "no sample for 0.09")):
        file = csv(tmp_path / f"{name}.csv", with_gap)
        with pytest.raises(InputError, match=rf"{words}.*complete it, or give gaps: fill"):
            on_wheel(file)
        filled = heights_of(on_wheel(file, gaps="fill"))
        assert np.abs(filled - whole).max() < 2e-7
    half = csv(tmp_path / "half.csv", rows[:360])
    with pytest.raises(InputError, match="no sample for 3"):
        on_wheel(half)


def test_a_rail_begins_where_told_without_its_slope_and_repeats_if_told(tmp_path):
    x = np.arange(0.0, 3.0, 2.5e-4)
    high = 2e-5 * np.sin(2 * np.pi * x / 0.3) + 1e-3 * x + 0.5 + 1e-5 * np.sin(2 * np.pi * x / 0.0013)
    profile = Profile("rail_1", csv(tmp_path / "rail.csv", zip(x, high, strict=True)), "m", "m", start=2.0, ramp=0.3)
    heights = rail_heights([profile], "rail_1", 10_000, DX, Y).all()[:, 0]
    assert not heights[:2000].any()
    assert not heights[5001:].any()
    middle = np.arange(2400, 4600)
    smooth = 2e-5 * np.sin(2 * np.pi * (middle * DX - 2.0) / 0.3)
    assert np.abs(heights[middle] - smooth).max() < 2e-6
    with pytest.raises(InputError, match=r"repeats with a step of 3e\+03 um .*: give drift: remove"):
        dataclasses.replace(profile, start=0.0, repeat=True)
    repeated = dataclasses.replace(profile, start=0.0, repeat=True, drift="remove")
    along = rail_heights([repeated], "rail_1", 9000, DX, Y).all()[:, 0]
    assert (along[:3000] == along[6000:]).all()
    assert np.abs(along[:3000] - 2e-5 * np.sin(2 * np.pi * np.arange(3000) * DX / 0.3)).max() < 1e-5
    with pytest.raises(InputError, match=r"repeats after 3 m, the line after 10 m: give a line_length of 12 m"):
        rail_heights([repeated], "rail_1", 10_000, DX, Y)
    with pytest.raises(InputError, match=r"ramp = 1\.6 m at both ends is more than the 2\.999 m of .* give 1\.4995 m"):
        rail_heights([dataclasses.replace(profile, ramp=1.6)], "rail_1", 10_000, DX, Y)


@given(
    count=st.integers(20, 900),
    steps=st.integers(300, 3000),
    orders=st.sets(st.integers(1, 9), min_size=1, max_size=3),
    first=st.floats(0.0, 1.0),
)
def test_a_periodic_function_sampled_at_any_spacing_and_repeated_is_itself(
    tmp_path_factory, count, steps, orders, first
):
    period = steps * DX
    x = first + period * np.arange(count) / count
    high = waves(2 * np.pi * (x - first) / period, *orders)
    file = csv(tmp_path_factory.mktemp("rail") / "r.csv", zip(x, high, strict=True))
    profile = Profile("rail_1", file, "m", "m", repeat=True)
    heights = rail_heights([profile], "rail_1", 3 * steps, DX, Y).all()[:, 0]
    assert heights == pytest.approx(waves(2 * np.pi * np.arange(3 * steps) / steps, *orders), abs=1e-12)


def test_what_cannot_be_used_is_refused_in_one_line(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    good = csv(tmp_path / "good.csv", zip(angle, waves(angle, 2), strict=True))
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "words.csv").write_text("a,b\n1,2\nx,y\n")
    (tmp_path / "ragged.csv").write_text("1,2\n1,2,3\n")
    (tmp_path / "broken.npy").write_bytes(b"no array")
    np.save(tmp_path / "complex.npy", np.zeros((9, 2), complex))
    np.save(tmp_path / "large.npy", np.zeros((100_001, 2)))
    twice = csv(tmp_path / "twice.csv", zip(np.repeat(angle, 2), np.repeat(angle, 2), strict=True))
    for options, words in (
        ({"file": str(tmp_path / "none.csv")}, "cannot be read"),
        ({"file": str(tmp_path / "binary.csv")}, "is not text"),
        ({"file": str(tmp_path / "words.csv")}, "line 3: 'x' is not a number"),
        ({"file": str(tmp_path / "ragged.csv")}, "line 2 has 3 cells"),
        ({"file": str(tmp_path / "broken.npy")}, "is not a NumPy file"),
        ({"file": str(tmp_path / "complex.npy")}, "complex128: give real numbers"),
        ({"file": str(tmp_path / "large.npy")}, "holds 200002 numbers: give 200000 at most"),
        ({"file": twice}, "two samples at"),
        ({"along": "inch"}, "along = 'inch' is not a known unit"),
        ({"on": "rail_1"}, "along = rad applies to wheels only"),
        (
            {"on": "rail_1", "along": "m", "angle": 1.0},
            "angle applies to wheels only: leave it out for rail_1, and give start",
        ),
        ({"start": 3.0}, "start and repeat apply to rails only"),
    ):
        with pytest.raises(InputError, match=words) as refusal:
            Profile(**{"on": "wheel_1", "file": good, "along": "rad", "height": "m"} | options)
        assert "\n" not in str(refusal.value)


def test_a_scenario_takes_the_table_in_and_needs_no_file_any_more(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    file = csv(tmp_path / "tread.csv", zip(angle, waves(angle, 2), strict=True))
    text = load_scenario("undamaged", ["name=own"]).to_yaml().replace("irregularities: []", "")
    (tmp_path / "own.yaml").write_text(
        text + "irregularities: [{type: profile, on: wheel_1, file: tread.csv, along: rad, height: m}]\n"
    )
    scenario = load_scenario(tmp_path / "own.yaml")  # found beside the scenario
    (tmp_path / "tread.csv").unlink()
    (tmp_path / "again.yaml").write_text(scenario.to_yaml())
    assert load_scenario(tmp_path / "again.yaml") == scenario
    assert heights_of(scenario.irregularities[0]).any(), file
