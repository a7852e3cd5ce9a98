"""Studies of a few short runs: small defects, little track."""

from pathlib import Path
from typing import Any

import pytest

from wheelset_track_sim.inputs.yaml12 import dump

SMALL: dict[str, Any] = {
    "title": "Two depths at two speeds",
    "scenario": "damage_wheel_1",
    "vary": {"speed": {"values": [90, 100], "unit": "km/h"}, "irregularities.0.h": [0.0, 0.0003]},
    "window": {"before": 0.1, "after": 0.1},
    "outputs": ["wheels.wheel_1.max_force", "wheels.wheel_1.min_force", "nodes.A1.max_principal"],
}


@pytest.fixture
def small() -> dict[str, Any]:
    """What a small study's file says; to be changed at will."""
    return {key: dict(value) if isinstance(value, dict) else value for key, value in SMALL.items()}


@pytest.fixture
def study_file(tmp_path: Path):
    """Write a study and return its path."""

    def write(content: dict[str, Any], name: str = "small") -> str:
        path = tmp_path / f"{name}.yaml"
        path.write_text(dump(content), encoding="utf-8")
        return str(path)

    return write
