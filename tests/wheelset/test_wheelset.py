from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
import yaml

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.wheelset.kinds import load_wheelset, read_wheelset
from wheelset_track_sim.wheelset.wheelset import Wheelset


@pytest.fixture
def plain(x40: Wheelset) -> dict[str, Any]:
    """The X40 as a mapping that can be spoiled."""
    return yaml.safe_load(yaml.safe_dump(_lists(asdict(x40))))  # type: ignore[no-any-return]


def _lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return [_lists(item) for item in value] if isinstance(value, tuple) else value


def test_mapping_file_and_name_agree(x40: Wheelset, plain: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(plain), encoding="utf-8")
    assert load_wheelset(plain) == x40
    assert load_wheelset(path) == x40
    assert read_wheelset(x40, "wheelset") is x40
    assert [node.name for node in x40.stress_nodes] == ["A1", "B1", "C1"]


def test_unknown_name_lists_the_shipped_ones() -> None:
    with pytest.raises(InputError, match=r"x41.*x40"):
        load_wheelset("x41")


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("wheel.rolling_radius", float("nan"), "rolling_radius = nan is not finite"),
        ("wheel.rolling_radius", 0.2, "rim_radius = 0.393 m is not less than rolling_radius"),
        ("wheel.hub_radius", 0.09, "seat = 0.096 m is not less than hub_radius"),
        ("wheel.hub_inner", 0.640, "wheel hub .* does not sit on the cylinder of one axle section"),
        ("wheel.contact", 0.70, "flange = 0.712 m is not less than contact"),
        ("wheel.tread", 1.0, "wheel.tread is not a known key"),
        ("material.poissons_ratio", 0.5, "poissons_ratio = 0.5 is out of range"),
        (
            "axle_boxes.bearing_length",
            0.15,
            "bearing of the axle box .* does not sit on the cylinder of one axle section",
        ),
        ("axle.sections.0.end", -1.2, "axle section journal_1 ends at y = -1.2 m"),
        ("axle.sections.2.fillet", 0.005, "fillet after axle section wheel_seat_1 .* give more than .* 0.006 m"),
        ("axle.sections.1.end", -0.93, "axle section abutment_1 is shorter than its fillets"),
        ("axle.sections.1.name", "journal_1", "axle.sections has names .* give each a name of its own"),
        ("gearbox.length", 0.6, "gearbox: end = 0.703 m is not less than hub_inner = 0.655 m"),
        ("axle.sections", [], "axle.sections is empty"),
        ("axle.bore", -0.01, "axle.bore = -0.01 m is out of range"),
        ("axle.bore", 0.12, "bore = 0.12 m leaves too thin a wall of axle section journal_1: give at most .* 0.108 m"),
        ("gearbox.y", 0.5, "gearbox .* does not sit on the cylinder of one axle section"),
        ("brake_discs.outer_radius", 0.4, "outer_radius = 0.4 m is not less than rim_radius"),
        ("stress_nodes.0.after", "seat", "stress_nodes.A1.after"),
        ("stress_nodes.0.name", "B1", "give each a name of its own"),
    ],
)
def test_bad_input_is_refused(plain: dict[str, Any], path: str, value: Any, message: str) -> None:
    *keys, last = path.split(".")
    place: Any = plain
    for key in keys:
        place = place[int(key) if isinstance(place, list) else key]
    place[int(last) if isinstance(place, list) else last] = value
    with pytest.raises(InputError, match=message) as refusal:
        load_wheelset(plain)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("name", shipped.names("wheelsets"))
def test_shipped_wheelsets_can_be_used(name: str) -> None:
    assert load_wheelset(name).name == name


def test_fillets_of_the_x40(x40: Wheelset) -> None:
    steps = {step.after: step for step in x40.axle.steps()}
    assert len(steps) == 8
    a1 = steps["wheel_seat_1"]
    # Tangent to the body of radius 90 mm, up 6 mm on a radius of 40 mm.
    assert a1.tangent == pytest.approx(-0.645 + (0.040**2 - 0.034**2) ** 0.5)
    assert steps["abutment_1"].tangent < steps["abutment_1"].edge == -0.85
