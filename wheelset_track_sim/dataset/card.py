"""The card of a data set: what it holds and what made it, for programs and for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..inputs.schema import plain
from .labels import SPLITS
from .passing import program
from .spec import DatasetSpec

if TYPE_CHECKING:
    from .store import ChunkStore

CARD, PAGE = "card.json", "README.md"
DRAWN = (
    *("speed", "axle_load", "length", "worn_length", "a", "b", "h", "y", "wheel_roughness", "rail_roughness"),
    *("pad_scatter", "ballast_scatter", "joint_position", "joint_dip_angle"),
)
"""Columns of which the card has the range."""


def card_of(
    spec: DatasetSpec, store: ChunkStore, columns: Mapping[str, list[Any]], versions: Mapping[str, str]
) -> dict[str, Any]:
    """The card without what the data set as a whole says; ``columns`` are those of the labels."""
    ranges = {}
    for name in DRAWN:
        known = np.array(columns[name])[np.isfinite(columns[name])]
        if len(known):
            ranges[name] = [float(known.min()), float(known.max())]
    splits = {}
    for split in SPLITS:
        rows = [row for row, of in enumerate(columns["split"]) if of == split]
        splits[split] = {
            "samples": len(rows),
            "wheelsets": len({columns["wheelset"][row] for row in rows}),
            "damage": dict(sorted(Counter(columns["damage"][row] for row in rows).items())),
        }
    return {
        "title": spec.title,
        "description": spec.description,
        "licence": spec.licence,
        "arrays": {
            name: {"shape": list(plan.shape), "dimensions": list(plan.dimensions)} | dict(plan.attributes)
            for name, plan in store.plans.items()
        },
        "splits": splits,
        "ranges": ranges,
        "versions": dict(versions),
        "program": program(),
        "spec": plain(spec),
    }


def page_of(card: Mapping[str, Any]) -> str:
    """The card as a page of Markdown."""
    lines = [f"# {card['title']}", card["description"].strip(), f"Licence: {card['licence']}."]
    lines.append(
        f"{card['samples']} simulated samples, seed {card['seed']}, {card['failed']} failed (NaN). Labels are in "
        "`labels.parquet`, SI units; all that made the data set is in `card.json` and `spec.yaml`."
    )
    lines += ["## Arrays", "| array | channels | unit | shape |\n|---|---|---|---|\n" + _arrays(card)]
    lines += ["## Splits by wheelset", "| part | samples | wheelsets | damage |\n|---|---:|---:|---|\n" + _splits(card)]
    rows = "\n".join(f"| `{name}` | {low:.6g} | {high:.6g} |" for name, (low, high) in card["ranges"].items())
    lines += ["## Ranges", "| column | from | to |\n|---|---:|---:|\n" + rows]
    versions = ", ".join(f"{name} {version}" for name, version in card["versions"].items())
    lines += ["## Made by", f"{versions}; digest of the program {card['program']}."]
    return "\n\n".join(line for line in lines if line) + "\n"


def _arrays(card: Mapping[str, Any]) -> str:
    return "\n".join(
        f"| `{name}` | {', '.join(about['channels'])} | {about['units'] or '1'} | "
        f"{' x '.join(map(str, about['shape']))} |"
        for name, about in card["arrays"].items()
    )


def _splits(card: Mapping[str, Any]) -> str:
    return "\n".join(
        f"| {name} | {of['samples']} | {of['wheelsets']} | "
        + ", ".join(f"{kind} {count}" for kind, count in of["damage"].items())
        + " |"
        for name, of in card["splits"].items()
    )
