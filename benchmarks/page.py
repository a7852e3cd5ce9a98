"""Writes the figures of docs/performance.md, between its markers, from the results of ``make bench``.

python -m benchmarks.page [FILE.json ...]        from the root; prints the tables, too

Of several files the better result of each benchmark counts: so one can measure again what a busy machine has spoilt.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tools.validation.page import Cell, number, paragraphs, table

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "performance.md"
RESULTS = ROOT / "results" / "benchmarks.json"
CORES = ("one core", "all cores")
MEMORY = {"run[damage_wheel_1]": "run", "run[rough_wheel]": "run of rough wheels", "node": "node"}


class Results:
    """Benchmarks by name, of one machine."""

    def __init__(self, found: list[dict[str, Any]]) -> None:
        machine = found[-1]["machine_info"]
        if any(each["machine_info"] != machine for each in found):
            raise SystemExit("the results are of different machines or versions: give those of one")
        self.machine, self.versions = machine["cpu"], machine["versions"]
        self._by_name: dict[str, Any] = {}
        for run in (run for each in found for run in each["benchmarks"]):
            name = run["name"]
            if name not in self._by_name or _merit(run) > _merit(self._by_name[name]):
                self._by_name[name] = run

    def best(self, name: str) -> float | None:
        """Best time of a call, s; None if it was not measured."""
        return self._by_name[name]["stats"]["min"] if name in self._by_name else None

    def fact(self, name: str, key: str = "real_time_factor") -> float | None:
        """A number that the benchmark left."""
        return self._by_name[name]["extra_info"].get(key) if name in self._by_name else None

    def facts(self, start: str) -> list[dict[str, Any]]:
        """Numbers of all benchmarks whose names begin alike, with the best time of each as ``best``."""
        return [
            run["extra_info"] | {"best": run["stats"]["min"]}
            for name, run in self._by_name.items()
            if name.startswith(start)
        ]


def _merit(run: dict[str, Any]) -> float:
    """The larger the better: by what the benchmark measured itself, or its best time."""
    facts = run["extra_info"]
    for key, sense in (
        ("real_time_factor", 1),
        ("in_real_time", 1),
        ("in_a_second", 1),
        ("share_of_core", -1),
        ("ratio", -1),
        ("processor_s", -1),
    ):
        if key in facts:
            return float(sense * facts[key])
    return -float(run["stats"]["min"])


def machine(r: Results) -> str:
    """One line."""
    cpu = r.machine
    return (
        f"{cpu['brand_raw']} ({cpu['target']}), {cpu['count']} cores; Python {r.versions['python']}, NumPy "
        f"{r.versions['numpy']}, Numba {r.versions['numba']}. One core unless said otherwise."
    )


def goals(r: Results) -> str:
    """What was to be reached, and what is."""
    cases = ("undamaged", "damage_wheel_1", "damage_both")
    core = _least(r.fact(f"test_run[{case}]") for case in cases)
    bag = _least(r.fact(f"test_run_with_bag[{case}]") for case in cases)
    node = r.fact("test_node[alone]")
    plain = r.fact("test_plain[smooth]")
    ratio = None if core is None or plain is None else core / plain
    spreads = [r.fact(f"test_memory_of_{what}", "spread") for what in MEMORY]
    worst = None if None in spreads else 100 * max(s for s in spreads if s is not None)
    rows = [
        ("`run`, discrete defects or smooth wheels, in memory, with stresses", _times(core), "60 ×", _met(core, 60)),
        ("the same with the bag written at full rate", _times(bag), "25 ×", _met(bag, 25)),
        ("node as fast as possible, everything published and recorded", _times(node), "15 ×", _met(node, 15)),
        ("the first against the plain reference", _times(ratio), "5000 ×", _met(ratio, 5000)),
        _goal(r, "roughness on both treads and rails, contact solved in every step", "test_rough", 1),
        ("warm start of the node to its first chunk", *_seconds(r.fact("test_node[alone]", "start_s"), 2)),
        ("warm start of the library to its first chunk", *_seconds(r.best("test_warm"), 2)),
        ("cold start: no models, no tables; kernels compiled", *_seconds(r.best("test_without_models"), 15)),
        ("cold start: nothing cached, all cores", *_seconds(r.best("test_with_nothing[all cores]"), 15)),
        (
            "resident memory over an hour, after its first minute",
            "–" if worst is None else f"± {number(worst / 2)} %",
            "± 5 %",
            _met(worst, 10, least=False),
        ),
    ]
    return table(("", "measured", "goal", "met"), rows)


def _goal(r: Results, what: str, name: str, goal: float) -> tuple[str, str, str, str]:
    found = r.fact(name)
    return what, _times(found), f"{goal:g} ×", _met(found, goal)


def _seconds(found: float | None, goal: float) -> tuple[str, str, str]:
    return "–" if found is None else f"{number(found)} s", f"{goal:g} s", _met(found, goal, least=False)


def _met(found: float | None, goal: float, *, least: bool = True) -> str:
    if found is None:
        return "not measured"
    return "yes" if (found >= goal if least else found <= goal) else "no"


def _times(found: float | None) -> str:
    return "–" if found is None else f"{number(found, 0 if found >= 10 else 2 if found >= 0.1 else 4)} ×"


def _least(found: Any) -> float | None:
    values = list(found)
    return None if None in values else min(values)


PARTS = {
    "modes of the wheelset, both displacements": "test_wheelset",
    "modes of the track, both halves": "test_track",
    "stress sums": "test_stress",
    "two look-ups in force tables": "test_look_ups",
}


def profile(r: Results) -> str:
    """Time of each part, and the bounds."""
    flops = r.fact("test_multiply_adds", "flops") / r.best("test_multiply_adds")  # type: ignore[operator]
    loads = {run["cache"]: run["bytes"] / run["best"] for run in r.facts("test_loads")}
    rows: list[tuple[Cell, ...]] = []

    def row(what: str, name: str) -> float:
        best, steps = r.best(name), r.fact(name, "steps")
        assert best is not None
        assert steps is not None
        measured = 1e9 * best / steps
        if r.fact(name, "flops") is None:
            rows.append((what, measured, *[None] * 5))
            return measured
        work = {key: r.fact(name, key) or 0.0 for key in ("flops", "near", "far")}
        arithmetic = 1e9 * work["flops"] / flops
        memory = 1e9 * (work["near"] / loads["L1"] + work["far"] / loads["L3"])
        bytes_ = number((work["near"] + work["far"]) / 1e3)
        rows.append(
            (what, measured, number(work["flops"], 0), bytes_, arithmetic, memory, measured / max(arithmetic, memory))
        )
        return measured

    alone = sum(row(what, name) for what, name in PARTS.items())
    together = row("all of it in one loop, the coupled step", "test_coupled_step")
    rows.insert(len(PARTS), ("sum of these", alone, *[None] * 5))
    principal = row("maximum principal stresses", "test_principal_stress")
    block = row("coupled step and blocks", "test_block")
    rows[-1] = ("blocks: memory, checks, hand over", block - together, *[None] * 5)
    whole = row("", "test_block_and_summary")
    rows[-1] = ("summary of blocks", whole - block - principal, *[None] * 5)
    rows.append(("**together, a step of `run`**", f"**{number(whole, 0)}**", *[None] * 5))
    period = 1e6 / 27.7777778  # ns at 1 mm
    rates = ", ".join(f"{number(rate / 1e9, 0)} GB/s from {cache}" for cache, rate in loads.items())
    return paragraphs(
        table(
            ("part", "ns a step", "flop", "kB", "arithmetic, ns", "memory, ns", "measured to larger bound"),
            rows,
            (0, 0, 0, 1, 0, 0, 2),
        ),
        f"A step of real time takes {number(period, 0)} ns at 100 km/h, so {number(whole, 0)} ns are "
        f"{number(period / whole, 0)} × real time. Measured most of this machine: {number(flops / 1e9, 0)} Gflop/s "
        f"(product of matrices), {rates} (sum of an array).",
    )


def reference(r: Results) -> str:
    """The same run three ways."""
    rows = []
    for what, smooth, impact in (
        (
            "plain: NumPy convolution, active set set up anew (`benchmarks/plain.py`)",
            "test_plain[smooth]",
            "test_plain[impact]",
        ),
        (
            "`paper` dynamics of the package, contact solved in every step",
            "test_paper_dynamics[smooth]",
            "test_paper_dynamics[impact]",
        ),
        (
            "`causal` dynamics, contact solved in every step",
            "test_solver_in_every_step[undamaged]",
            "test_solver_in_every_step[damage_wheel_1]",
        ),
        ("`causal` dynamics with tables", "test_advance[undamaged]", "test_advance[damage_wheel_1]"),
    ):
        found = [r.fact(name) for name in (smooth, impact)]
        plain = r.fact("test_plain[smooth]")
        ratio = None if found[0] is None or not plain else found[0] / plain
        rows.append((what, *map(_times, found), number(ratio, 0)))
    return table(("", "smooth treads", "with a defect", "smooth, to plain"), rows)


def scaling(r: Results) -> str:
    """All tables of growth."""
    runs: list[str] = []

    def add(head: tuple[str, ...], start: str, keys: tuple[str, ...], digits: tuple[int, ...]) -> None:
        rows = [[run[key] for key in keys] for run in r.facts(start)]
        runs.append(table((*head, "× real time"), [[*row] for row in rows], digits))

    factor = "real_time_factor"
    add(("after simulated time, s",), "test_after", ("seconds", factor), (0, 0))
    add(
        ("bays of the ring", "modes of the ring", "time to reduce them, s"),
        "test_bays",
        ("bays", "ring_modes", "reduction_s", factor),
        (0, 0, 1, 0),
    )
    add(("states of a half track",), "test_states", ("order", factor), (0, 0))
    add(("modes of the wheelset",), "test_modes", ("modes", factor), (0, 0))
    add(
        ("defects", "off the middle, mm", "tables", "MB", "time to build them, s"),
        "test_defects",
        ("defects", "y_mm", "tables", "tables_mb", "tables_s", factor),
        (0, 0, 0, 1, 1, 0),
    )
    return paragraphs(*runs)


def contact(r: Results) -> str:
    """Solvers side by side."""
    runs = r.facts("test_half_space")
    solvers = list(dict.fromkeys(run["solver"] for run in runs))
    rows = []
    for problem in dict.fromkeys(run["problem"] for run in runs):
        of = {run["solver"]: run for run in runs if run["problem"] == problem}
        first = next(iter(of.values()))
        times = [1e3 * of[name]["best"] if name in of else None for name in solvers]
        rows.append([problem, first["grid"], number(first["inside"], 0), *times])
    errors = [run["error"] for run in runs]
    asked = {kind: r.best(f"test_contact_in_the_run[{kind}]") for kind in ("table", "solver")}
    each = {kind: 1e9 * best / 1000 for kind, best in asked.items() if best is not None}
    return paragraphs(
        table(("problem", "elements", "in contact", *(f"{name}, ms" for name in solvers)), rows, (0, 0, 0, 2, 1, 1)),
        f"The pressures agree within {max(errors):.0e} of the largest. In the run, with the contact of the last step "
        f"as the first guess, a solution takes {number(each.get('solver', 0.0) / 1e3, 0)} µs, one look-up in a table "
        f"{number(each.get('table', 0.0), 0)} ns.",
    )


def more(r: Results) -> str:
    """Bags, nodes, starts, fleets, memory."""
    fleets, nodes, costs = (r.facts(start) for start in ("test_fleet[", "test_fleet_of_nodes[", "test_cost_of_a_fleet"))
    rows = [
        ("bag written, all eighteen components busy", _times(r.fact("test_bag", "write"))),
        ("bag read", _times(r.fact("test_bag", "read"))),
        *(
            (f"node on one core, everything published and recorded, {who}", _times(r.fact(f"test_node[{who}]")))
            for who in ("alone", "with a subscriber")
        ),
        *((f"cold start, nothing cached, {n}", _seconds(r.best(f"test_with_nothing[{n}]"), 15)[0]) for n in CORES),
        *((f"fleet of {run['wheelsets']} on two cores, in memory", _in_real_time(run)) for run in fleets),
        *(
            (f"fleet of {run['wheelsets']} nodes in a process", f"{100 * run['share_of_core']:.1f} % of a core each")
            for run in nodes
        ),
        *(
            (
                f"time of a fleet of {run['wheelsets']} over {run['wheelsets']} times that of one",
                number(run["ratio"], 2),
            )
            for run in costs
        ),
        ("acceleration at both axle boxes, share of the coupled step", _share(r.fact("test_two_axle_boxes", "share"))),
        *(
            (f"fatigue at three nodes and 36 angles, share of the run, {run['case']}", _share(run["to_run"]))
            for run in r.facts("test_three_nodes_at_36_angles[")
        ),
        *(
            (
                f"resident memory of the {MEMORY[what]} over an hour, first minute left out",
                _span(r, f"test_memory_of_{what}"),
            )
            for what in MEMORY
        ),
    ]
    return table(("", "measured"), rows)


def _in_real_time(run: dict[str, Any]) -> str:
    return f"{number(run['in_real_time'], 0)} wheelsets in real time"


def _share(found: float | None) -> str:
    return "–" if found is None else f"{100 * found:.1f} %"


def _span(r: Results, name: str) -> str:
    least, most = (r.fact(name, key) for key in ("least_mb", "most_mb"))
    return "–" if least is None or most is None else f"{least:.0f} to {most:.0f} MB"


ROUGH, UNROUND = ("rough_wheel", "rail_roughness"), ("polygon", "measured_tread", "mixed")
GOALS = dict.fromkeys(ROUGH, 0.33) | dict.fromkeys(UNROUND, 0.4)
GOALS |= dict.fromkeys(("scattered_support", "hanging_sleeper"), 0.25) | {"everything": 0.12}
"""Share of the factor of smooth wheels, by case."""


def ratios(r: Results) -> str:
    """Goals that are ratios to smooth wheels in the same run; of several cases the slowest counts."""
    found = {run["case"]: run["to_smooth"] for run in (*r.facts("test_filter["), *r.facts("test_supports["))}
    smooth = _least(r.fact(f"test_run[{case}]") for case in ("undamaged", "damage_wheel_1", "damage_both"))
    node, together = r.fact("test_node[rough wheels]"), r.fact("test_cost_of_a_fleet[8]", "ratio")
    node = None if node is None or smooth is None else node / smooth
    together = None if together is None else 1.0 / together
    rows = [
        (what, _least(found.get(case) for case in cases), goal)
        for what, cases, goal in (
            ("roughness on treads or rails", ROUGH, 0.33),
            ("polygon, measured tread, mixed", UNROUND, 0.4),
            ("supports that vary", ("scattered_support", "hanging_sleeper"), 0.25),
            ("everything together", ("everything",), 0.12),
        )
    ]
    rows += [
        ("eight wheelsets in one process on one core, sum of their factors", together, 2.7),
        ("node, everything published and recorded, rough wheels", node, 0.15),
        ("new defects a second, one passage each", r.fact("test_distinct_defects", "in_a_second"), 30.0),
    ]
    shown = [
        (what, "–" if of is None else number(of, 0 if goal >= 10 else 2), f"{goal:g}", _met(of, goal))
        for what, of, goal in rows
    ]
    return table(("", "measured", "goal", "met"), shown)


def rates(r: Results) -> str:
    """Processor load of a node in real time, by chunks a second and subscribers."""
    found = {(run["rate"], run["subscribers"]): run["share_of_core"] for run in r.facts("test_rate[")}
    listeners = sorted({subscribers for _, subscribers in found})
    rows = [
        (f"{rate} Hz", *(f"{100 * found[rate, subscribers]:.0f} %" for subscribers in listeners))
        for rate in sorted({rate for rate, _ in found})
    ]
    return table(("chunks a second", *(f"{n} subscribers" if n != 1 else "1 subscriber" for n in listeners)), rows)


def passages(r: Results) -> str:
    """Distinct defects a second, both ways."""
    return table(
        ("a second, on one core", "defects"),
        [
            ("passages from a kept run", number(r.fact("test_distinct_defects", "in_a_second"), 0)),
            (
                "a simulation each, with force tables",
                number(r.fact("test_distinct_defects", "in_a_second_with_tables"), 1),
            ),
        ],
    )


def wayside(r: Results) -> str:
    """Passages of wayside detectors."""
    rows = [
        (
            run["detector"],
            int(run["channels"]),
            number(run["passage_s"], 3),
            number(run["new_speed_s"], 2),
            number(run["to_simulation"], 2),
        )
        for run in r.facts("test_wayside[")
    ]
    return table(("detector", "channels", "a passage, s", "at a new speed, s", "to its simulation"), rows)


def contact_filter(r: Results) -> str:
    """Rough and out-of-round wheels against smooth ones."""
    rows = []
    for run in (*r.facts("test_filter["), *r.facts("test_supports[")):
        goal, found = GOALS.get(run["case"]), run["to_smooth"]
        rows.append(
            (
                run["case"].replace("_", " "),
                _times(run["real_time_factor"]),
                number(found, 2),
                "–" if goal is None else number(goal, 2),
                "–" if goal is None else _met(found, goal),
                number(run["solved_to_smooth"], 2),
                f"{100 * run['share_filtered']:.1f} %" if run["share_filtered"] else "–",
                f"{run['largest_estimate']:.0f} N" if run["share_filtered"] else "–",
            )
        )
    heads = ("case", "factor", "to smooth", "goal", "met", "solved, to smooth", "filtered", "largest estimate")
    return table(heads, rows)


def lines(r: Results) -> str:
    """Steps of bays against those of modes."""
    rows = [
        (run["case"], run["line_ns"], run["modes_ns"], number(run["ratio"], 1)) for run in r.facts("test_line_step[")
    ]
    return table(("case", "bays, ns", "modes, ns", "bays to modes"), rows)


def changes(r: Results) -> str:
    """Time of the processor for starts and changes."""
    rows = [(f"start: {run['what']}", number(run["processor_s"], 2)) for run in r.facts("test_start[")]
    rows += [(f"change: {run['kind']}", number(run["processor_s"], 2)) for run in r.facts("test_change[")]
    return table(("", "s"), rows)


SECTIONS: dict[str, Callable[[Results], str]] = {
    "machine": machine,
    "goals": goals,
    "ratios": ratios,
    "profile": profile,
    "reference": reference,
    "filter": contact_filter,
    "passages": passages,
    "wayside": wayside,
    "lines": lines,
    "changes": changes,
    "scaling": scaling,
    "contact": contact,
    "rates": rates,
    "more": more,
}


def main(*files: str) -> None:
    """Put every section between its markers, and print it."""
    results = Results([json.loads(Path(file).read_text()) for file in files or (RESULTS,)])
    page = PAGE.read_text(encoding="utf-8")
    for name, section in SECTIONS.items():
        text = section(results)
        print(f"\n{text}")
        place = re.compile(rf"(?<=<!-- {name} -->\n)((?!<!-- end).)*(?=<!-- end -->)", re.DOTALL)
        filled, count = place.subn(lambda _, text=text: f"\n{text}\n\n", page)
        if count != 1:
            raise SystemExit(f"{PAGE.name} has {count} places for {name}: give it one")
        page = filled
    PAGE.write_text(page, encoding="utf-8")
    print(f"\n{PAGE.relative_to(ROOT)} is written")


if __name__ == "__main__":
    main(*sys.argv[1:])
