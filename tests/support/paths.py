"""Places of the project."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OLD_BAG = ROOT / "tests" / "data" / "damage_wheel_1_of_0_1.mcap"
"""Bag that version 0.1.0 recorded."""
