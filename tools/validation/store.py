"""Results on disk under a digest of all that changes them, so that a second call has nothing to compute."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from wheelset_track_sim import contact, green, irregularities, simulation, stress, structures
from wheelset_track_sim.runtime.cache import digest
from wheelset_track_sim.scenario import scenario

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "results" / "validation"
PHYSICS: tuple[ModuleType, ...] = (contact, green, irregularities, scenario, simulation, stress, structures)


def recall(what: str, inputs: Any, compute: Callable[[], Any], *sources: ModuleType) -> Any:
    """What ``compute`` returns (plain numbers, text, lists and mappings), stored or computed and then stored.

    ``sources`` are the modules of this program that the result depends on, beside all of the package's physics.
    """
    path = FOLDER / f"{what}-{digest(inputs, *PHYSICS, *sources)[:16]}.json"
    if path.exists():
        return json.loads(path.read_text())
    print(f"{what}: {_short(inputs)} ...", end="", flush=True)
    start = time.perf_counter()
    found = compute()
    print(f" {time.perf_counter() - start:.1f} s", flush=True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(found))
    temporary.replace(path)
    return json.loads(path.read_text())


def this_module(name: str) -> ModuleType:
    """Module by its ``__name__``."""
    return sys.modules[name]


def _short(inputs: Any) -> str:
    text = str(inputs)
    return text if len(text) < 100 else text[:97] + "..."
