"""Units that people write."""

from wheelset_track_sim.inputs.units import UNITS, unit_named


def test_every_unit_is_known_by_its_name_and_other_spellings() -> None:
    for name in UNITS:
        assert unit_named(f" {name} ") == name
    spelled = {"µm": "um", "μm": "um", "µs": "us", "KN": "kN", "°": "deg", "N/mm²": "MPa", "dB re 1 µm": "dB"}
    assert {text: unit_named(text) for text in spelled} == spelled
    assert [unit_named(text) for text in ("", "inch", "t", "wheel_1", "m/s")] == [""] * 5
