"""Writes docs/validation.md and its figures from results, which are stored in results/validation.

python -m tools.validation        from the root; needs the test extra (make validation sees to it)
"""

from __future__ import annotations

import sys

from . import (
    contacts,
    coupling,
    first,
    hardness,
    impact,
    joints,
    load_cases,
    railfe,
    ripple,
    steps,
    tracks,
    vehicles,
    wheelset_checks,
    wheelsets,
)
from .page import paragraphs
from .store import ROOT

PAGE = ROOT / "docs" / "validation.md"


def main() -> int:
    """Compute what is missing, write the page; 1 if a package is missing."""
    missing = contacts.missing()
    if missing:
        print(f"{', '.join(missing)} not installed: run `python3 tools/setup_env.py test` first", file=sys.stderr)
        return 1
    cases = load_cases.runs()
    causal, paper = impact.runs(impact.CAUSAL), impact.runs(impact.AS_PRINTED)
    static = wheelset_checks.facts()["static"]
    sections = [
        load_cases.section(cases),
        impact.section(causal, paper, cases["undamaged"]),
        ripple.section(static[0]),
        contacts.section(),
        wheelsets.section(),
        tracks.section(),
        steps.section(),
        hardness.section(),
        coupling.section(),
        joints.section(),
        railfe.section(),
        vehicles.section(),
        ripple.appendix(static[0]),
    ]
    PAGE.write_text(paragraphs(*first.screen(cases, causal, paper), *sections) + "\n", encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)} is written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
