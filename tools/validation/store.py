"""Results on disk under a digest of all that changes them, so that a second call has nothing to compute."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from wheelset_track_sim.runtime.cache import digest
from wheelset_track_sim.runtime.sources import program

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "results" / "validation"


def recall(what: str, inputs: Any, compute: Callable[[], Any], *others: Callable[..., Any] | None) -> Any:
    """What ``compute`` returns (plain numbers, text, lists and mappings), stored or computed and then stored.

    A stored result counts as long as ``inputs`` and the sources of ``compute`` and of all ``others`` that it calls are
    the same: their modules with all that these import.
    """
    programs = [program(_plain(function).__module__) for function in (compute, *others) if function is not None]
    path = FOLDER / f"{what}-{digest([inputs, programs])[:16]}.json"
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


def _plain(function: Callable[..., Any]) -> Callable[..., Any]:
    return _plain(function.func) if isinstance(function, partial) else function


def _short(inputs: Any) -> str:
    text = str(inputs)
    return text if len(text) < 100 else text[:97] + "..."
