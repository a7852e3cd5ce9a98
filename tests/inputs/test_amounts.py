"""Amounts that people type: numbers with units of their quantity's dimension."""

from __future__ import annotations

import typing
import warnings
from dataclasses import dataclass, fields, is_dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError, InputWarning, recorded_input
from wheelset_track_sim.inputs.amounts import BASES, FURTHER, GRAVITY, amount, others, size_of, unit_of
from wheelset_track_sim.inputs.schema import Quantity, quantity, read
from wheelset_track_sim.inputs.units import UNITS
from wheelset_track_sim.irregularities.kinds import OWN
from wheelset_track_sim.scenario import Scenario
from wheelset_track_sim.studies import Study
from wheelset_track_sim.wheelset import harmonics


def quantities(owner: typing.Any, seen: set[type]) -> typing.Iterator[Quantity]:
    """Every quantity of a dataclass and of those within it."""
    if is_dataclass(owner) and owner not in seen:
        seen.add(owner)  # type: ignore[arg-type]
        hints = typing.get_type_hints(owner)
        for field in fields(owner):
            if "quantity" in field.metadata:
                yield field.metadata["quantity"]
            yield from quantities(hints[field.name], seen)
    for part in typing.get_args(owner):
        yield from quantities(part, seen)


SEEN: set[type] = set()
ALL = sorted({each for owner in (Scenario, Study, *OWN.values()) for each in quantities(owner, SEEN)}, key=repr)
NAMES = [*UNITS, *FURTHER, "km/h", "N s/m", "kN/mm", "cm4", "mm^2", "t/m3", "m/s²", "kg m2"]


@pytest.mark.parametrize(
    ("text", "si", "value"),
    [
        ("100 km/h", "m/s", 250 / 9),
        ("60 mm", "m", 0.06),
        ("60mm", "m", 0.06),
        (" 2.5 ", "m", 2.5),
        ("22.5 t", "N", 220725.0),
        ("20000 kg", "N", 196200.0),
        ("98.1kN", "N", 98100.0),
        ("-9.81e1 kN", "N", -98100.0),
        ("120 kN/mm", "N/m", 120e6),
        ("25 kNs/m", "N s/m", 25e3),
        ("5 kNm", "N m", 5e3),
        ("5 kN*m", "N m", 5e3),
        ("3055 cm4", "m4", 3.055e-5),
        ("0.7686 dm2", "m2", None),
        ("7.85 g/cm³", "kg/m3", 7850.0),
        ("90°", "rad", 1.5707963267948966),
        ("0.5 m/s²", "m/s^2", 0.5),
        ("210 N/mm^2", "Pa", 210e6),
        ("5 %", "", 0.05),
        ("2.5 t", "kg", 2500.0),
        ("5 t", "Pa", None),
        ("5 t", "N m", None),
        ("100 mm", "m/s", None),
        ("10 mm", "", None),
        ("98,1 kN", "N", None),
        ("9 8 kN", "N", None),
        ("kN", "N", None),
        ("", "N", None),
        ("1e-320 N", "N", 1e-320),
        ("1e999 N", "N", None),
        ("1e999999999 N", "N", None),
        ("5 m/s/s", "m/s^2", None),
        ("5 m/", "m", None),
        ("nan", "m", None),
    ],
)
def test_texts(text: str, si: str, value: float | None) -> None:
    if value is None:
        with pytest.raises(
            InputError, match=r"^key = .* is (not (a number|in a unit of this quantity)|too large for a number): give"
        ):
            amount(text, si, "key")
    else:
        assert amount(text, si, "key") == value  # the same bits as typed in SI


@given(st.sampled_from(ALL), st.floats(0, 1), st.data())
def test_what_is_printed_in_any_unit_comes_back(of: Quantity, share: float, data: st.DataObject) -> None:
    value = of.low + share * (of.high - of.low)
    names = [name for name in NAMES if size_of(name, of.unit) is not None]
    name = data.draw(st.sampled_from([of.unit, *others(of.unit), *names]))
    size = size_of(name, of.unit)
    assert size is not None
    printed = f"{value / float(size)!r} {name}"
    assert amount(printed, of.unit, "x") == pytest.approx(value, rel=1e-14, abs=1e-300)


@given(st.sampled_from(ALL), st.text(max_size=12))
def test_any_text_is_an_amount_or_refused(of: Quantity, text: str) -> None:
    try:
        value = of.number("x", text)
    except InputError:
        return
    assert of.low <= value <= of.high


def test_units_of_all_quantities_and_their_others_are_known() -> None:
    for of in ALL:
        assert unit_of(of.unit) is not None
        for name in others(of.unit):
            assert size_of(name, of.unit) is not None
    assert {unit.dimension for unit in UNITS.values()} == set(BASES)


def test_gravity_is_that_of_the_models() -> None:
    assert float(GRAVITY) == harmonics.GRAVITY


@dataclass(frozen=True)
class Ride:
    speed: float = quantity("m/s", 5.0, 100.0, "the speed", usual=(5.0, 65.0))
    load: float = quantity("N", 2e4, 4e5, "the load", default=1e5, usual=(4e4, 4e5))
    depth: float | None = quantity("m", 0.0, 0.01, "the depth", default=None)
    count: int = quantity("", 1, 300, "the count", default=1)
    share: float = quantity("", 0.0, 1.0, "the share", default=0.5)


def ride(**given: object) -> Ride:
    return read(Ride, {"speed": 30} | given, "ride")


@pytest.mark.filterwarnings("error")
def test_quantities_are_read_with_units() -> None:
    assert ride(speed="360 km/h", load="4 t", depth="2 mm", count="300 %") == Ride(100.0, 39240.0, 0.002, 3)
    assert ride(speed=65, load=4e4, depth=None) == Ride(65, 4e4)
    assert isinstance(ride(count="300 %").count, int)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {"speed": 100},
            "ride.speed = 100 is taken as 100 m/s (360 km/h), and looks like 100 km/h (27.7778 m/s)",
        ),
        (
            {"load": 22000},
            "is taken as 22000 N (22 kN), and looks like 22000 kg (215820 N): write 22000 kg if",
        ),
    ],
)
def test_a_number_that_looks_like_another_unit_is_reported(given: dict[str, object], told: str) -> None:
    with pytest.warns(InputWarning) as found:
        ride(**given)
    assert told in str(found[0].message)
    with warnings.catch_warnings(), recorded_input():
        warnings.simplefilter("error")
        ride(**given)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {"speed": 160},
            "give the speed from 5 to 100 m/s; 160 km/h would be 44.4444 m/s",
        ),
        ({"load": 22.5}, "from 20000 to 400000 N; 22.5 t would be 220725 N"),
        ({"load": 225}, "from 20000 to 400000 N; 225 kN would be 225000 N"),
        ({"depth": 2}, "from 0 to 0.01 m; 2 mm would be 0.002 m"),
        (
            {"speed": "400 km/h"},
            "ride.speed = 400 km/h, which is 111.111 m/s, is out of range: give the speed",
        ),
        ({"speed": "30 N"}, "is not in a unit of this quantity: give a number alone, which is in m/s, or with one of"),
        ({"load": "30 m"}, "or with one of N, kN, t, kg, MN (t and kg times 9.81 m/s^2)"),
        ({"count": "2.5"}, "ride.count = 2.5 is not of type int"),
        ({"share": 30}, "ride.share = 30 is out of range: give the share from 0 to 1; 30 % would be 0.3"),
    ],
)
def test_refusals_name_the_other_unit(given: dict[str, object], told: str) -> None:
    with pytest.raises(InputError) as refusal:
        ride(**given)
    assert told in str(refusal.value)


@pytest.mark.parametrize("given", [{"speed": -160}, {"depth": -2}, {"share": -1}, {"count": -1}, {"count": 2000}])
def test_refusals_name_no_unit_that_does_not_help(given: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r" is out of range: give the \w+ from \S+ to \S+( m| m/s)?$"):
        ride(**given)
