"""Units that people write."""

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.units import UNITS, unit_named, value_of


def test_every_unit_is_known_by_its_name_and_other_spellings() -> None:
    for name in UNITS:
        assert unit_named(f" {name} ") == name
    spelled = {"µm": "um", "μm": "um", "µs": "us", "KN": "kN", "°": "deg", "N/mm²": "MPa", "dB re 1 µm": "dB"}
    assert {text: unit_named(text) for text in spelled} == spelled
    assert [unit_named(text) for text in ("", "inch", "t", "wheel_1", "m/s")] == [""] * 5


@pytest.mark.parametrize(
    ("text", "value"), [("98.1kN", 98100.0), (" 98100 ", 98100.0), ("-9.81e1 kN", -98100.0), ("98100 N", 98100.0)]
)
def test_values_have_units_or_are_in_si(text: str, value: float) -> None:
    assert value_of(text, "force", "--offset") == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["98.1 t", "98.1 mm", "kN", "", "98,1 kN", "9 8 kN"])
def test_what_is_no_force_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"--offset .* is not a force: give a number with one of N, kN"):
        value_of(text, "force", "--offset")
