"""How contacts without a force table were found, as commands print it."""

from __future__ import annotations

import math
from typing import Any

from ..samples.summary import Summary


def contact(of: Summary) -> dict[str, Any]:
    """The object that commands print with ``--json``; empty if it is not known."""
    found = of.contacts
    if math.isnan(found.largest_estimate):
        return {}
    return {
        "solved_steps": found.solved_steps,
        "filtered_steps": found.filtered_steps,
        "largest_estimate_N": found.largest_estimate,
    }


def contact_words(counts: dict[str, Any]) -> str:
    """The same for people; empty if there were none, or if it is not known."""
    solved, filtered = counts.get("solved_steps", 0), counts.get("filtered_steps", 0)
    if filtered:
        return f"{filtered} filtered, error up to {counts['largest_estimate_N']:.0f} N estimated; {solved} solved"
    return f"{solved} solved" if solved else ""
