import dataclasses
from pathlib import Path

import pytest
import yaml

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.shipped import load_yaml
from wheelset_track_sim.track.track import Track, load_track, read_track


@pytest.fixture
def plain() -> dict:
    return load_yaml("tracks", "ballasted_60e1")


def test_shipped_track_is_that_of_table_1() -> None:
    track = load_track("ballasted_60e1")
    stiffness = [track.rail.EI, track.rail.kGA, track.sleeper.EI, track.sleeper.kGA]
    by_hand = [210e9 * 3.05e-5, 0.40 * 210e9 / 2.6 * 7.69e-3, 37.5e9 * 2.12e-4, 0.845 * 37.5e9 / 2.4 * 5.44e-2]
    assert stiffness == pytest.approx(by_hand)
    assert track.rail.rhoA == pytest.approx(7800 * 7.69e-3)
    assert (track.sleeper.elements, track.rail.elements_per_bay) == (20, 8)
    assert (track.pad.stiffness, track.pad.damping) == (120e6, 25e3)
    assert (track.ballast.stiffness, track.ballast.damping) == (104e6, 86e3)


def test_rotational_pad_springs_are_those_of_equations_20_and_21() -> None:
    pad = load_track("ballasted_60e1").pad
    assert pad.rotational_stiffness == pytest.approx(120e6 * 0.15**2 / 12)
    assert pad.rotational_damping == pytest.approx(25e3 * 0.15**2 / 12)


def test_name_file_mapping_and_track_are_the_same(plain: dict, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(plain))
    track = load_track("ballasted_60e1")
    assert load_track(file) == load_track(plain) == read_track(track, "track") == track
    assert load_track(dataclasses.asdict(track)) == track


def test_unknown_name_lists_the_shipped_tracks() -> None:
    with pytest.raises(InputError, match=r"slab.*known are.*ballasted_60e1"):
        load_track("slab")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sleepers": 1}, "sleepers"),
        ({"spacing": float("nan")}, "spacing.*finite"),
        ({"spacing": -0.6}, "spacing.*out of range"),
        ({"rail_distance": 2.6}, "rail_distance.*sleeper length.*2.5"),
        ({"rail": {"density": 7800.0}}, "rail.youngs_modulus is missing"),
        ({"pad": {"stiffness": 120e6, "damping": 0.0}}, "pad.damping.*out of range"),
        ({"ballast": {"stiffness": "soft", "damping": 8e4}}, "ballast.stiffness.*not a number"),
    ],
)
def test_what_cannot_be_used_is_named_in_one_line(plain: dict, change: dict, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        load_track({**plain, **change})
    assert "\n" not in str(refused.value)
    assert isinstance(load_track(plain), Track)


@pytest.mark.parametrize("elements", [19, 20.0, 0])
def test_a_sleeper_takes_an_even_whole_number_of_elements(plain: dict, elements: object) -> None:
    plain["sleeper"]["elements"] = elements
    with pytest.raises(InputError, match="elements"):
        load_track(plain)


def test_slab_track_has_neither_sleepers_nor_ballast(plain: dict) -> None:
    assert load_track("slab_60e1").sleeper is None
    for missing, name in (("sleeper", "sleeper"), ("ballast", "ballast")):
        with pytest.raises(InputError, match=f"{name} is missing: give both"):
            load_track({key: value for key, value in plain.items() if key != missing})


def test_a_base_gives_what_is_not_said(tmp_path: Path) -> None:
    track = load_track({"base": "ballasted_60e1", "name": "mine", "pad": {"stiffness": 9e7}})
    base = load_track("ballasted_60e1")
    assert track == dataclasses.replace(base, name="mine", pad=dataclasses.replace(base.pad, stiffness=9e7))
    (tmp_path / "one.yaml").write_text("base: ballasted_60e1\nspacing: 0.65\n")
    again = load_track({"base": str(tmp_path / "one.yaml"), "rail_distance": 1.6})
    assert again == dataclasses.replace(base, spacing=0.65, rail_distance=1.6)


def test_a_base_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"known are.*ballasted_60e1"):
        load_track({"base": "nowhere"})
    with pytest.raises(InputError, match=r"track\.base = 3"):
        load_track({"base": 3})
    own = tmp_path / "own.yaml"
    own.write_text(f"base: {own}\n")
    with pytest.raises(InputError, match=r"track\.base = .*own\.yaml"):
        load_track(own)
