"""``dataset``: write a labelled data set, or rebuild a sample of one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..dataset.card import PAGE
from ..dataset.spec import load_spec
from ..dataset.writing import rebuild, stored, write_dataset
from ..errors import WheelsetTrackError
from ..studies.conduct import Resources
from .console import print_object, terminal
from .progress import shown


def dataset(name: str, out: Path, samples: int, seed: int, resources: Resources, *, json: bool) -> int:
    """Write a data set and print its card; returns the exit status."""
    spec = load_spec(name)
    with shown() as progress:
        card = write_dataset(spec, out, samples=samples, seed=seed, resources=resources, progress=progress)
    if json:
        print_object(card)
        return 0
    console = terminal()
    for split, of in card["splits"].items():
        kinds = ", ".join(f"{kind} {count}" for kind, count in of["damage"].items())
        console.print(f"{split}: {of['samples']} samples of {of['wheelsets']} wheelsets ({kinds})", highlight=False)
    console.print(f"data set {out}, card {out / PAGE}", highlight=False, soft_wrap=True)
    return 0


def rebuilt(folder: Path, sample: int, *, json: bool) -> int:
    """Simulate a sample again and compare it with the stored one; returns the exit status.

    Raises WheelsetTrackError if a bit differs.
    """
    again, there = rebuild(folder, sample), stored(folder, sample)
    differ = [name for name, values in again.items() if values.tobytes() != there[name].tobytes()]
    found: dict[str, Any] = {"sample": sample, "arrays": sorted(again), "differ": differ}
    if json:
        print_object(found)
    if differ:
        largest = max(float(np.nanmax(np.abs(again[name] - there[name]))) for name in differ)
        raise WheelsetTrackError(
            f"sample {sample} of {folder} differs in {', '.join(differ)} by up to {largest:g}: another version of the "
            "program or of its libraries, or another processor, made it"
        )
    if not json:
        terminal().print(f"sample {sample} of {folder} is the same in all bits", highlight=False, soft_wrap=True)
    return 0
