"""Files of a view: its scenario, and one turn of it as a bag, a table, a picture and a report."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

from ..bags.exports import export, form_of
from ..bags.run_arrays import read_bag
from ..errors import InputError
from ..inputs.schema import unknown
from ..live.run_messages import record
from ..report import plot_run, survey
from ..report.page import write_report
from ..samples.summary import summarise
from ..scenario import Scenario
from ..simulation.simulator import Simulator

FORMS = {
    ".yaml": "scenario",
    ".mcap": "bag",
    ".csv": "table",
    ".png": "picture, PNG",
    ".svg": "picture, SVG",
    ".html": "report",
}
"""What a file is, by its suffix."""
CHUNK = 1389
"""Steps from block to block in a bag."""


def content(scenario: Scenario, suffix: str) -> bytes:
    """Content of a file: of the scenario itself, or of one turn of the wheel as ``run`` simulates it.

    Raises InputError for a suffix that is none of ``FORMS``, and what the simulation raises.
    """
    if suffix not in FORMS:
        raise InputError(unknown("form of file", repr(suffix), suffix, [*FORMS]))
    if suffix == ".yaml":
        return scenario.to_yaml().encode()
    recorded = _recorded(scenario)
    if suffix == ".mcap":
        return recorded
    with TemporaryDirectory(prefix="explore_") as folder:
        bag, out = Path(folder) / "run.mcap", Path(folder) / f"explored{suffix}"
        bag.write_bytes(recorded)
        form = form_of(out) if suffix == ".csv" else None
        if form is not None:
            export(read_bag(bag), out, form)
        elif suffix == ".html":
            write_report(survey(bag), out)
        else:
            plot_run(survey(bag), out)
        return out.read_bytes()


@lru_cache(maxsize=1)
def _recorded(scenario: Scenario) -> bytes:
    """Bag of one turn, 0.4 MB; people often want several files of one view."""
    simulator = Simulator(scenario)
    simulator.settle()
    with TemporaryDirectory(prefix="explore_") as folder:
        bag = Path(folder) / "run.mcap"
        with record(bag, simulator) as push:
            while (left := simulator.steps_per_revolution - simulator.next_step) > 0:
                block = simulator.advance(min(CHUNK, left))
                push(block, summarise(block))
        return bag.read_bytes()
