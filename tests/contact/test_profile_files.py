"""Files of lateral profiles, whichever way their axes point and whichever program wrote them."""

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from support.paths import ROOT
from support.written import Form, forms
from wheelset_track_sim.contact.geometry import ProfilePair
from wheelset_track_sim.contact.named_profiles import load_profile
from wheelset_track_sim.contact.profiles import Points, RailHead, inclined
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.inputs.tables import read_table
from wheelset_track_sim.scenario import load_scenario, scenario_from

WHEEL = ROOT / "tests" / "data" / "wheel_profile.csv"
RAIL = ROOT / "tests" / "data" / "rail_profile.csv"
SIDES = ["wheel", "rail"]
FILES = {"wheel": WHEEL, "rail": RAIL}


def points(side: str) -> np.ndarray:
    """Points of the file of a side, mm."""
    return np.column_stack([column.values for column in read_table(FILES[side]).columns])


def written(path: Path, of: np.ndarray, heading: str = "y_mm,z_mm") -> Path:
    path.write_text("\n".join([heading, *(f"{y:.4f},{z:.4f}" for y, z in of), ""]))
    return path


def same(found: object, side: str, within: float = 1e-9) -> None:
    expected = points(side) / 1e3
    assert isinstance(found, Points)
    np.testing.assert_allclose(found.y, expected[:, 0], atol=within)
    datum = expected[:, 1].max() - found.z.max() if side == "rail" else 0.0
    np.testing.assert_allclose(found.z + datum, expected[:, 1], atol=within)


@pytest.mark.parametrize("side", SIDES)
@given(form=forms())
def test_every_form_of_table_is_the_same_profile(
    tmp_path_factory: pytest.TempPathFactory, side: str, form: Form
) -> None:
    path = form.write(tmp_path_factory.getbasetemp() / "profile.txt", ("y", "z"), ("mm", "mm"), points(side).tolist())
    same(load_profile(side, path, "it"), side)


@pytest.mark.slow
@pytest.mark.parametrize("side", SIDES)
@settings(max_examples=20)
@given(
    turn_y=st.booleans(),
    turn_z=st.booleans(),
    backwards=st.booleans(),
    datum=st.floats(-0.4, 0.4),
    noise=st.integers(0, 2**32 - 1),
)
def test_axes_and_datum_of_a_file_do_not_matter(
    tmp_path_factory: pytest.TempPathFactory,
    side: str,
    turn_y: bool,
    turn_z: bool,
    backwards: bool,
    datum: float,
    noise: int,
) -> None:
    """Heights that count downwards, y to the gauge side, points in the other order, z from anywhere."""
    assume(side == "rail" or not 1e-9 < abs(datum) <= 0.0105)  # which is taken as what a wheel has worn
    of = points(side) + np.array([0.0, 1e3 * datum])
    of[:, 1] += 0.002 * np.random.default_rng(noise).standard_normal(len(of))
    of *= [-1.0 if turn_y else 1.0, -1.0 if turn_z else 1.0]
    path = written(tmp_path_factory.getbasetemp() / "profile.csv", of[::-1] if backwards else of)
    # A new rail is symmetric: y does not show, and does not matter.
    turned = (turn_z, turn_y and side == "wheel")
    with pytest.warns(InputWarning) if any(turned) else nullcontext() as warned:
        found = load_profile(side, path, "it")
    if any(turned):
        told = " ".join(str(each.message) for each in warned)
        assert [f"turn: {axis}" in told for axis in "zy"] == [*turned]
    same(found, side, within=2e-5)
    told = {(False, False): "none", (True, False): "y", (False, True): "z", (True, True): "both"}[turn_y, turn_z]
    given = load_profile(side, {"file": str(path), "turn": told}, "it")  # and no warning
    np.testing.assert_allclose(given.height([-0.01, 0.0, 0.02]), found.height([-0.01, 0.0, 0.02]), atol=2e-5)


@given(origin=st.floats(-200.0, 200.0))
def test_a_profile_that_counts_from_elsewhere_is_refused_until_its_origin_is_given(
    tmp_path_factory: pytest.TempPathFactory, origin: float
) -> None:
    path = tmp_path_factory.getbasetemp() / "shifted.csv"
    for side, least in (("wheel", 40.0), ("rail", 13.0)):
        if abs(origin) > least:
            written(path, points(side) + np.array([origin, 0.0]))
            with pytest.raises(InputError, match=r"give y from there, or origin|does not cover the running surface"):
                load_profile(side, path, "it")
            same(load_profile(side, {"file": str(path), "origin": round(origin, 4) / 1e3}, "it"), side, within=1e-6)


@pytest.mark.slow
@settings(max_examples=15)
@given(tangent=st.floats(0.005, 0.1), datum=st.floats(-1.0, 1.0))
def test_no_constant_in_the_heights_of_a_rail_moves_the_contact(tangent: float, datum: float) -> None:
    """F8: 172 mm, from foot to top of a rail, moved the contact of a rail leaning by 1/40 by 4.3 mm."""
    y = np.linspace(-0.035, 0.035, 281)
    heights = RailHead().height(y)
    contacts = [
        ProfilePair(load_profile("wheel", "cylinder", ""), inclined(Points(y, heights + off), tangent)).touch
        for off in (0.0, datum)
    ]
    assert contacts[1] == pytest.approx(contacts[0], abs=2e-5)
    assert contacts[0] == pytest.approx(ProfilePair(rail=inclined(RailHead(), tangent)).touch, abs=1e-4)


def test_the_wheel_of_the_issue_touches_where_it_does() -> None:
    """F1: with z downwards its flange was read as a groove, and the wheel ran beside its tread."""
    changes = ["profiles.inclination=0.05", f"profiles.wheel_1={WHEEL}"]
    assert load_scenario("undamaged", changes).geometry.touch(0) == pytest.approx(0.0, abs=1e-3)


def test_points_in_a_scenario_are_turned_and_those_of_a_bag_stay() -> None:
    """A bag repeats what ran, whichever way its points went."""
    y, z = (points("wheel") / 1e3).T
    plain = {"y": y.tolist(), "z": (-z).tolist()}
    with pytest.warns(InputWarning, match=r"profiles\.wheel_1: the flange has z = -28.5 mm"):
        scenario = load_scenario("undamaged", [f"profiles.wheel_1={plain}"])
    np.testing.assert_allclose(scenario.profiles.wheel_1.z, z, atol=1e-12)
    again = scenario_from(scenario.to_mapping() | {"profiles": {"wheel_1": plain}})
    np.testing.assert_array_equal(again.profiles.wheel_1.z, -z)


def worn_rail(depth: float) -> np.ndarray:
    of = points("rail")
    return np.column_stack([of[:, 0], of[:, 1] - depth * np.clip((-of[:, 0] - 15.0) / 10.0, 0.0, 1.0)])


@pytest.mark.slow
@settings(max_examples=15)
@given(depth=st.floats(2.5, 8.0))
def test_a_rail_that_is_worn_at_the_field_side_is_warned_of(
    tmp_path_factory: pytest.TempPathFactory, depth: float
) -> None:
    path = tmp_path_factory.getbasetemp() / "worn.csv"
    right = load_profile("rail", written(path, worn_rail(depth)), "it")
    written(path, worn_rail(depth) * [-1.0, 1.0])
    with pytest.warns(InputWarning, match=r"as if worn more: give turn: y if y counts to the gauge side"):
        load_profile("rail", path, "it")
    turned = load_profile("rail", {"file": str(path), "turn": "y"}, "it")
    np.testing.assert_allclose(turned.height([-0.025, 0.01]), right.height([-0.025, 0.01]), atol=1e-9)


def miniprof(of: np.ndarray) -> str:
    rows = "\n".join(f"{y:.4f}\t{z:.4f}\t0.1\t0.2" for y, z in of)
    return f"[General]\nDate=2024-05-02\nColumnDef=X,Y,A,C\nStock=7,8\n\n{rows}\n"


def simpack(side: str, of: np.ndarray, **keys: float) -> str:
    given = {"shift.y": 0.0, "units.len.f": 1000.0} | {name.replace("_", "."): value for name, value in keys.items()}
    lines = "\n".join(f"  {name} = {value:+.9e}   ! a key" for name, value in given.items())
    rows = "\n".join(f"{y:.6f} {z:.6f} ! a point" for y, z in of)
    head = f"! Profile\nheader.begin\n  version = 1\n  type = {int(side == 'wheel')}\nheader.end\nspline.begin\n"
    return f"{head}{lines}\n  point.begin\n  ! y z\n{rows}\n  point.end\nspline.end\n"


@pytest.mark.parametrize(
    ("side", "suffix", "text"),
    [
        ("wheel", ".whl", miniprof),
        ("wheel", ".WHL", miniprof),
        ("rail", ".ban", miniprof),
        ("rail", ".rail", miniprof),
        ("wheel", ".prw", lambda of: simpack("wheel", of * [1.0, -1.0])),
        ("rail", ".prr", lambda of: simpack("rail", of * [1.0, -1.0])),
        ("rail", ".prr", lambda of: simpack("rail", of / 1e3 * [1.0, -1.0], units_len_f=1.0)),
        ("wheel", ".prw", lambda of: simpack("wheel", of[::-1], mirror_z=1.0, inversion=1.0)),
        ("wheel", ".prw", lambda of: simpack("wheel", of * [-1.0, -1.0] - [3.0, 0.0], shift_y=3.0, mirror_y=1.0)),
        ("rail", ".prr", lambda of: simpack("rail", np.pad(of * [1, -1], ((1, 1), (0, 0)), constant_values=99.0),
                                            bound_y_min=-50.0, bound_y_max=50.0)),
        ("rail", ".prr", lambda of: simpack("rail", of @ [[0.8, 0.6], [0.6, -0.8]], rotate=-np.arctan2(0.6, 0.8))),
    ],
)  # fmt: skip
def test_files_of_other_programs(tmp_path: Path, side: str, suffix: str, text: Callable[[np.ndarray], str]) -> None:
    path = tmp_path / f"profile{suffix}"
    path.write_text(text(points(side)))
    same(load_profile(side, path, "it"), side, within=1e-6)


def test_sides_that_overhang_are_left_out_of_measured_files(tmp_path: Path) -> None:
    of = points("rail")
    below = [[-34.0 + 0.3 * k, -15.0 - k] for k in range(8, 0, -1)], [[34.0 - 0.3 * k, -15.0 - k] for k in range(1, 9)]
    path = tmp_path / "profile.ban"
    path.write_text(miniprof(np.concatenate([below[0], of, below[1]])))
    same(load_profile("rail", path, "it"), "rail", within=1e-6)


def test_a_file_of_any_suffix_is_read(tmp_path: Path) -> None:
    """F12: a file that exists was called an unknown name."""
    for name in ("wheel.txt", "wheel.dat", "wheel", "WHEEL.CSV"):
        path = tmp_path / name
        path.write_bytes(WHEEL.read_bytes())
        same(load_profile("wheel", path, "it"), "wheel")
    scenario = tmp_path / "mine.yaml"
    text = load_scenario("undamaged").to_yaml()
    scenario.write_text(text.replace("wheel_1: cylinder", "wheel_1: wheel.txt").replace(
        "wheel_2: cylinder", "wheel_2: {file: WHEEL.CSV}"
    ))  # fmt: skip
    profiles = load_scenario(scenario).profiles  # found beside the scenario
    assert profiles.wheel_1 == profiles.wheel_2 == load_profile("wheel", WHEEL, "it")


def test_several_wheels_of_a_file_are_chosen_by_name(tmp_path: Path) -> None:
    y, z = points("wheel").T
    rows = "\n".join(f"{a};{b};{c}" for a, b, c in zip(y, z, z - 0.4, strict=True))
    path = tmp_path / "both.csv"
    path.write_text(f"y [mm];left [mm];right [mm]\n{rows}\n")
    with pytest.raises(InputError, match=r"has no column z: give column, .*: y \[mm\], left \[mm\], right \[mm\]"):
        load_profile("wheel", path, "it")
    same(load_profile("wheel", {"file": str(path), "column": "left"}, "it"), "wheel")
    right = load_profile("wheel", {"file": str(path), "column": "3"}, "it")
    assert right.z[0] == pytest.approx(z[0] / 1e3 - 0.4e-3)
    path.write_text(f"y;z;w\n{rows}\n")
    with pytest.raises(InputError, match="'y' has no unit"):
        load_profile("wheel", path, "it")
    same(load_profile("wheel", {"file": str(path), "unit": "mm"}, "it"), "wheel")


@pytest.mark.parametrize(
    ("side", "name", "text", "words"),
    [
        ("wheel", "a.csv", "", "it: .*a.csv holds no numbers"),
        ("wheel", "a.csv", "1,2\n3,4\n", "column 1 has no unit"),
        ("wheel", "a.csv", "y_mm,z_inch\n1,2\n", "'z_inch' has no unit|has no column z"),
        ("wheel", "a.csv", "y_mm,z [inch]\n1,2\n", r"unit of 'z \[inch\]' is not a unit of length"),
        ("wheel", "a.csv", "y_mm,z_mm\n1,2\n3,\n", r"line 3 has no z \[mm\]: give one"),
        ("wheel", "a.prr", simpack("rail", points("rail")), "is the Simpack file of a rail: give the file of a wheel"),
        ("rail", "a.prr", "header.begin", "has no points between point.begin and point.end"),
        ("rail", "a.prr", "point.begin\n1 two\npoint.end", "is not a Simpack profile"),
        ("wheel", "a.csv", "y_mm,z_m\n-30,28\n" + "".join(f"{k},0\n" for k in range(-28, 60)), "give the unit"),
        ("wheel", "a.csv", "y_mm,z_mm\n" + "".join(f"{k},{0.1 * k}\n" for k in range(-30, 60)), "turn: y, z or both"),
    ],
)  # fmt: skip
def test_what_is_no_profile_is_refused(tmp_path: Path, side: str, name: str, text: str, words: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match=words) as refusal:
        load_profile(side, path, "it")
    assert "\n" not in str(refusal.value)
