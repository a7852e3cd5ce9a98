from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.schema import check, quantity, quantity_of, read


@dataclass(frozen=True)
class Spring:
    type: ClassVar[str] = "spring"
    stiffness: float = quantity("N/m", 1.0, 1e9, "the stiffness")

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Damper:
    type: ClassVar[str] = "damper"
    rate: float = quantity("N s/m", 0.0, 1e6, "the rate", default=5.0)


@dataclass(frozen=True)
class Assembly:
    name: str
    side: Literal["left", "right"]
    parts: tuple[Spring | Damper, ...]
    count: int = 1
    note: str | None = None


GOOD = {"name": "n", "side": "left", "parts": [{"type": "spring", "stiffness": 3}, {"type": "damper"}]}


def test_reads_nested_values_and_defaults() -> None:
    assembly = read(Assembly, GOOD, "a")
    assert assembly == Assembly("n", "left", (Spring(3.0), Damper(5.0)))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"nmae": 1}, ["a.nmae", "did you mean name"]),
        ({"side": "up"}, ["a.side", "'up'", "left, right"]),
        ({"parts": [{"type": "sprnig"}]}, ["a.parts.0.type", "did you mean spring"]),
        ({"parts": [{"stiffness": 1.0}]}, ["a.parts.0.type is missing"]),
        ({"parts": [{"type": "spring", "stiffness": 0.5}]}, ["a.parts.0.stiffness = 0.5 N/m", "from 1 to 1e+09 N/m"]),
        ({"parts": [{"type": "spring", "stiffness": float("nan")}]}, ["a.parts.0.stiffness", "not finite"]),
        ({"parts": [{"type": "spring", "stiffness": "much"}]}, ["a.parts.0.stiffness", "not a number"]),
        ({"parts": [{"type": "spring", "stiffness": True}]}, ["a.parts.0.stiffness", "not a number"]),
        ({"parts": [{"type": "spring"}]}, ["a.parts.0.stiffness is missing"]),
        ({"parts": "spring"}, ["a.parts", "not a list"]),
        ({"parts": [4]}, ["a.parts.0", "not"]),
        ({"count": 1.5}, ["a.count", "int"]),
        ({"note": 3}, ["a.note"]),
        ({"name": None}, ["a.name", "str"]),
    ],
)
def test_refuses_by_name(change: dict[str, object], words: list[str]) -> None:
    with pytest.raises(InputError) as refusal:
        read(Assembly, GOOD | change, "a")
    message = str(refusal.value)
    assert "\n" not in message
    for word in words:
        assert word in message


def test_refuses_what_is_no_mapping() -> None:
    with pytest.raises(InputError, match="a = 3 is not a mapping"):
        read(Assembly, 3, "a")


@given(st.one_of(st.floats(), st.integers(), st.text(), st.none(), st.booleans()))
def test_a_number_is_accepted_just_within_its_limits(value: object) -> None:
    limits = quantity_of(Spring, "stiffness")
    good = isinstance(value, (int, float)) and not isinstance(value, bool) and limits.low <= value <= limits.high
    assert (limits.refusal("x", value) is None) == good


def test_a_copy_is_checked_too() -> None:
    with pytest.raises(InputError, match="stiffness"):
        replace(Spring(2.0), stiffness=-1.0)
