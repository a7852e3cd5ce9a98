"""A turn of every shipped scenario as few plain numbers; ``tools/regression.py`` stores them, a test compares them."""

import json
from typing import Any

import numpy as np

from support.advancing import advance_to
from support.paths import ROOT
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

REFERENCE = ROOT / "tests" / "data" / "shipped_scenarios.json"
STEPS = 2900
"""A turn of the largest shipped wheel, and a little more."""
ROWS = np.linspace(0, STEPS - 1, 40).astype(int)


def numbers_of(name: str) -> dict[str, list[float]]:
    """Maximum, minimum, RMS and 40 samples of each wheel's force, N, and each node's maximum principal stress, Pa."""
    blocks = advance_to(Simulator(load_scenario(name)), STEPS)
    forces, principal = (
        np.concatenate([getattr(block, kind) for block in blocks]) for kind in ("forces", "max_principal")
    )
    signals = dict(zip(("wheel_1", "wheel_2", *blocks[0].nodes), np.hstack([forces, principal]).T, strict=True))
    return {signal: _numbers(values) for signal, values in signals.items()}


def _numbers(values: np.ndarray) -> list[float]:
    found = [values.max(), values.min(), np.sqrt(np.mean(values**2)), *values[ROWS]]
    return [float(f"{value:.10g}") for value in found]


def reference() -> dict[str, dict[str, list[float]]]:
    """The stored numbers, by scenario and signal."""
    stored: dict[str, Any] = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return stored


def text_of(numbers: dict[str, dict[str, list[float]]]) -> str:
    """Text of the file, a signal a line."""
    scenarios = []
    for name, signals in sorted(numbers.items()):
        lines = ",\n".join(f'  "{signal}": {json.dumps(values)}' for signal, values in signals.items())
        scenarios.append(f'"{name}": {{\n{lines}\n}}')
    return "{\n" + ",\n".join(scenarios) + "\n}\n"
