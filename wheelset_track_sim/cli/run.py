"""``run``: simulate without ROS, as fast as possible."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from rich.table import Table

from ..bags.exports import check_steps, exported, form_of
from ..bags.settings import RecordSettings
from ..errors import InputError, warn
from ..inputs.amounts import in_unit
from ..live.fatigue_watch import FatigueSettings
from ..live.run_messages import record
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..samples.impacts import ImpactSettings
from ..samples.spread import spreads
from ..samples.summary import Summary, combine, summarise
from ..scenario import WHEELS, Scenario, load_scenario
from ..scenario.events import OF_NODE
from ..simulation.instants import Contacts
from ..simulation.places import advanced, at_places, runs
from ..simulation.simulator import Simulator
from ..verdict.bending import AXIAL, BendingAmplitudes
from ..verdict.limit_set import DEFAULT_LIMITS, load_limits
from ..verdict.verdicts import verdicts, worst
from .console import print_object, terminal
from .contacts import contact, contact_words
from .progress import shown

CHUNK = 1389
"""Steps from block to block in a bag: 50 ms at 100 km/h."""

LONG_CHUNK = 4 * CHUNK
"""The same without a bag, where nobody sees the blocks: what a block costs apart from its steps is a sixth of 50 ms."""

LONGEST = 1e5
"""Longest run, s."""


def run(
    scenario: str,
    changes: Sequence[str],
    duration: float | None,
    out: Path | None,
    *,
    json: bool,
    settings: RecordSettings | None = None,
    impacts: ImpactSettings | None = None,
    limits: str = DEFAULT_LIMITS,
    places: int = 1,
    fatigue: FatigueSettings | None = None,
    warnings: Sequence[str] = (),
) -> int:
    """Simulate a scenario and print its peaks; returns the exit status.

    With ``places`` the damage meets the rail at that many places of the bay in turn, and peaks are printed of all.

    ``out`` is a bag, or a table by its suffix. ``settings`` say how a bag is recorded, ``impacts`` defines an impact
    there. ``limits`` is the set for the verdict, ``fatigue`` says how fatigue is counted for the bag. ``warnings`` grow
    during the run.
    """
    what, limit_set = load_scenario(scenario, changes), load_limits(limits)
    if duration is not None and not (math.isfinite(duration) and 0 < duration <= LONGEST):
        raise InputError(f"--duration {duration:g} s is out of range: give a time above 0, up to {LONGEST:g} s")
    bag, form = out, None if out is None else form_of(out)
    of_bags = impacts is not None or fatigue is not None or settings not in (None, RecordSettings())
    if out is not None and form is not None and of_bags:
        raise InputError(
            f"--out {out} is a table, and you gave options of bags: leave them out, or give {out.with_suffix('.mcap')}"
        )
    for index, event in enumerate(what.events):
        for key in (name for name in OF_NODE if getattr(event, name)):
            warn(f"events.{index}.{key} is for the node, and does nothing here: --out records the whole run")
    elsewhere = at_places(what, places)
    with ExitStack() as stack:
        progress = stack.enter_context(shown())
        simulator = Simulator(what, progress)
        simulator.require(steps_left(simulator, duration))
        if out is not None and form is not None:
            check_steps(out, form, steps_left(simulator, duration))
            bag = stack.enter_context(exported(out, form))
        simulator.settle()
        push: Callable[[SampleBlock, Summary], None] | None = None
        if bag is not None:
            push = stack.enter_context(record(bag, simulator, settings=settings, impacts=impacts, fatigue=fatigue))
        chunk = CHUNK if push else LONG_CHUNK
        means = simulator.constant_stress[:, AXIAL]
        bending = BendingAmplitudes(means, simulator.steps_per_revolution)
        started = time.perf_counter()
        totals: Summary | None = None
        contacts = Contacts()
        while (left := steps_left(simulator, duration)) > 0:
            block = simulator.advance(min(chunk, left))
            part = summarise(block)
            totals = part if totals is None else combine([totals, part])
            contacts.push(simulator, block)
            if limit_set is not None and limit_set.axle:
                bending.push(block)
            if push is not None:
                push(block, part)
            share = simulator.next_step / (simulator.next_step + left - len(block))
            progress(f"simulate {what.name}, {simulator.time:.2f} of {simulator.time / share:.2f} s", share)
        wall = time.perf_counter() - started
        assert totals is not None
        scatter = _scatter(elsewhere, simulator, totals, progress) if places > 1 else {}
    result = as_mapping(totals, simulator.time, wall) | {"pressures": pressures(what, contacts)}
    if scatter:
        result["scatter"] = scatter
    result |= {"scenario": what.name, "digest": simulator.digest, "warnings": [*warnings], **conditions(what)}
    if limit_set is not None:
        damage = [item for applied in simulator.history for item in applied.scenario.irregularities]
        amplitudes = dict(zip(block.nodes, bending.largest, strict=True)) if limit_set.axle else {}
        found = verdicts(limit_set, [wheel.max_force for wheel in totals.wheels], damage, amplitudes)
        result["verdict"] = {"limits": limit_set.name, "level": worst(found).word}
        result["verdict"]["comparisons"] = [{**each.mapping, "text": each.text} for each in found]
    varies = what.speed_plan or any(event.speed or event.axle_load for event in what.events)
    print_object(result) if json else terminal().print(table(result, " at the start" if varies else ""))
    return 0


def _scatter(places: tuple[Scenario, ...], done: Simulator, totals: Summary, progress: Progress) -> dict[str, Any]:
    """Extremes over places of the bay: of a run that is done at the first one, and as long ones at the others."""
    found = [peaks(totals)]
    for simulator in runs(places[1:], done.models):
        progress(f"simulate {len(places)} places", len(found) / len(places))
        found.append(peaks(combine([summarise(block) for block in advanced(simulator, totals.samples)])))
    progress(f"simulate {len(places)} places", 1.0)
    return {"places": len(places), **spreads(found)}


def steps_left(simulator: Simulator, duration: float | None) -> int:
    """Steps to the end of the run at the speed in force: one turn of the wheel, or ``duration`` s and one at least."""
    if duration is None:
        return simulator.steps_per_revolution - simulator.next_step
    return max(round((duration - simulator.time) / simulator.step_period), 1 - simulator.next_step)


def as_mapping(totals: Summary, simulated: float, wall: float) -> dict[str, Any]:
    """The object that ``run --json`` prints."""
    return {
        "steps": totals.samples,
        "simulated_s": simulated,
        "wall_s": wall,
        "real_time_factor": simulated / wall,
        **peaks(totals),
        "contact": contact(totals),
    }


def conditions(scenario: Scenario) -> dict[str, Any]:
    """What ran on what, and how fast at the start."""
    return {
        "speed_m_s": scenario.speed,
        "axle_load_N": scenario.axle_load,
        "wheelset": scenario.wheelset.name,
        "track": scenario.track.name,
    }


def peaks(of: Summary) -> dict[str, Any]:
    """Extremes of forces and stresses, as commands print them with ``--json``."""
    return {
        "wheels": {
            name: {"max_force_N": wheel.max_force, "min_force_N": wheel.min_force, "contact_loss_s": wheel.contact_loss}
            for name, wheel in zip(WHEELS, of.wheels, strict=True)
        },
        "nodes": {
            node.name: {"max_principal_Pa": node.max_principal, "min_principal_Pa": node.min_principal}
            for node in of.nodes
        },
    }


def pressures(scenario: Scenario, contacts: Contacts) -> dict[str, Any]:
    """Contact pressure at the largest force of each wheel; of smooth wheels on smooth rails none is worked out."""
    if not scenario.irregularities:
        return {}
    found: dict[str, Any] = {}
    for wheel, instant in zip(WHEELS, contacts.worst, strict=True):
        patch = instant.contact.solve()
        found[wheel] = {
            "largest_Pa": float(patch.pressure.max()),
            "hardness_Pa": patch.hardness,
            "share_at_hardness": patch.share_at_hardness,
            "flag": patch.flag,
        }
    return found


def table(result: dict[str, Any], when: str = "") -> Table:
    """The same for people: kN, MPa, ms; ``when`` the wheelset has the speed, if not always."""
    speed, load = in_unit(result["speed_m_s"], "km/h", "m/s"), result["axle_load_N"]
    shown_as = Table(
        title=f"{result['scenario']}: {result['simulated_s']:.4g} s, {result['real_time_factor']:.1f} x real time, "
        f"without the start\n{speed}{when}, {in_unit(load, 'kN', 'N')} axle load ({in_unit(load, 't', 'N')}), "
        f"{result['wheelset']} on {result['track']}",
        title_justify="left",
        caption_justify="left",
    )
    for heading in ("", "maximum", "minimum", "contact loss"):
        shown_as.add_column(heading, justify="right" if heading else "left")
    for name, wheel in result["wheels"].items():
        high, low, loss = wheel["max_force_N"] / 1e3, wheel["min_force_N"] / 1e3, wheel["contact_loss_s"] * 1e3
        shown_as.add_row(f"contact force {name}", f"{high:.1f} kN", f"{low:.1f} kN", f"{loss:.2f} ms")
    for name, node in result["nodes"].items():
        high, low = node["max_principal_Pa"] / 1e6, node["min_principal_Pa"] / 1e6
        shown_as.add_row(f"maximum principal stress {name}", f"{high:.1f} MPa", f"{low:.1f} MPa", "")
    for name, pressure in result["pressures"].items():
        shown_as.add_row(f"contact pressure {name}", f"{pressure['largest_Pa'] / 1e9:.2f} GPa", "", "")
    _add_scatter(shown_as, result.get("scatter", {}))
    flags = [f"{name}: {each['flag']}" for name, each in result["pressures"].items() if each["flag"]]
    notes = ["at the largest force, " + "; ".join(flags)] if flags else []
    if words := contact_words(result["contact"]):
        notes.append(f"contacts without a force table: {words}")
    if "verdict" in result:
        shown_as.add_section()
        shown_as.add_row("verdict", result["verdict"]["level"], "", "")
        notes += [each["text"] for each in result["verdict"]["comparisons"]]
    shown_as.caption = "\n".join(notes) or None
    return shown_as


def _add_scatter(table: Table, scatter: Mapping[str, Any]) -> None:
    """Rows of the extremes over places of the bay."""
    if not scatter:
        return
    table.add_section()
    table.add_row(f"over {scatter['places']} places of the bay", "largest", "median", "smallest")
    of = [(f"contact force {name}", wheel["max_force_N"], 1e3, "kN") for name, wheel in scatter["wheels"].items()]
    of += [
        (f"maximum principal stress {name}", node["max_principal_Pa"], 1e6, "MPa")
        for name, node in scatter["nodes"].items()
    ]
    for name, spread, size, unit in of:
        table.add_row(name, *(f"{spread[each] / size:.1f} {unit}" for each in ("max", "median", "min")))
