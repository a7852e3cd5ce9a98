"""Identify damage in synthetic forces: coverage of intervals, errors of sizes, kinds, predictions, and time.

python -m benchmarks.identification --cases 100 --out identification.jsonl

A case is a fresh flat, a worn flat or a breakout of random size, that strikes at a random place of the bay, off the
middle of the contact, in the third turn in a row. Forces are sampled at 10 kHz with a wrong gain, a wrong speed and
noise. In every other case the track has pads and ballast that are 10 % stiffer or softer, and as much more or less
damped, than those of the model. Every fourth case has three passages at three speeds, from which force and stress at
a fourth one are predicted. Cases that are in the file already are not run again.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from wheelset_track_sim.identification import Observation, identify, predict
from wheelset_track_sim.identification.kinds import KINDS, LATERAL
from wheelset_track_sim.runtime.arrays import Real
from wheelset_track_sim.samples.resampling import band_limited
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.passages import Passages

RATE, NOISE, GAIN, SPEED = 10e3, 2e3, 0.03, 0.005
"""Of the force signals: Hz, N, and errors as shares."""
OFF = 0.10
SPEEDS = (16.0, 34.0)
"""m/s"""
TURNS = 2
PLACES = 6
"""Of the true force and stress with which predictions are compared."""
SCENARIO = load_scenario("undamaged", ["settle_on=smooth"])


def off_track(pad: int, ballast: int) -> Scenario:
    """Scenario with pads and ballast that are stiffer (1) or softer (-1)."""
    track = SCENARIO.track
    assert track.ballast is not None
    parts = {
        name: dataclasses.replace(part, stiffness=part.stiffness * factor, damping=part.damping * factor)
        for name, part, factor in (("pad", track.pad, 1 + OFF * pad), ("ballast", track.ballast, 1 + OFF * ballast))
    }
    return dataclasses.replace(SCENARIO, track=dataclasses.replace(track, **parts))  # type: ignore[arg-type]


@cache
def passages(pad: int, ballast: int) -> Passages:
    """Passages on the true track, with hits in the turns before."""
    return Passages(off_track(pad, ballast), before=0.8, after=0.6 + TURNS * 2.713 + 1.7)


def hit(run: Passages, kind: str, sizes: list[float], y: float, place: float, speed: float) -> tuple[Any, int]:
    """Block of a passage, and the row at which the damage meets the rail for the last time."""
    own = run.scenario
    turn = own.steps_per_revolution * own.step_length
    angle = ((place - TURNS * turn) % own.track.spacing) / (turn / (2 * math.pi))
    block = run.run([KINDS[kind].make("wheel_1", sizes, angle, y)], speed=speed)
    return block, round((0.8 + angle * turn / (2 * math.pi) + TURNS * turn) / own.step_length)


def observed(random: np.random.Generator, run: Passages, kind: str, sizes: list[float], y: float) -> Observation:
    """A force signal of one passage."""
    speed = random.uniform(*SPEEDS)
    block, row = hit(run, kind, sizes, y, random.uniform(0.0, 0.6), speed)
    force = block.forces[row - 800 : row + 1600, :1]
    places = np.arange(0, len(force) - 1, 1 / RATE / block.step_period)
    true: Real = band_limited(force, places, 1 / RATE / block.step_period)[:, 0]
    values = (1 + GAIN * random.standard_normal()) * true + NOISE * random.standard_normal(len(true))
    reported = speed * (1 + SPEED * random.standard_normal())
    return Observation("force", np.arange(len(true)) / RATE, values, speed=reported)


def case(number: int) -> dict[str, Any]:
    """Run one case; it follows from its number alone."""
    random = np.random.default_rng([20, number])
    kind = [*KINDS][number % len(KINDS)]
    right, count = number % 2 == 0, 3 if number % 4 >= 2 else 1
    pad, ballast = (0, 0) if right else tuple(int(each) for each in random.choice([-1, 1], 2))
    length = float(np.exp(random.uniform(math.log(0.025), math.log(0.080))))
    sizes = {
        "flat": [length],
        "worn_flat": [length, random.uniform(1.3, 2.2)],
        "breakout": [length, math.exp(random.uniform(math.log(4e-4), math.log(3e-3))), random.uniform(0.6, 1) * length],
    }[kind]
    run = passages(pad, ballast)
    laterals = [min(abs(random.normal(0.0, LATERAL)), 0.012) for _ in range(count)]
    data = [observed(random, run, kind, sizes, y) for y in laterals]
    start, wall = time.process_time(), time.perf_counter()
    found = identify(data, SCENARIO, seed=number)
    result: dict[str, Any] = {
        "case": number,
        "kind": kind,
        "model": "right" if right else "off",
        "passages": count,
        "found": found.best.kind,
        "probability": found.best.probability,
        "chi2_per_n": found.best.chi2_per_n,
        "cpu_s": time.process_time() - start,
        "wall_s": time.perf_counter() - wall,
        "simulated": found.simulated,
        "true": dict(zip((each.name for each in KINDS[kind].unknowns), sizes, strict=True)),
    }
    fit = next((each for each in found.kinds if each.kind == kind and each.parameters), None)
    if fit is not None:
        result["intervals"] = {
            name: [fit.parameters[name].low, fit.parameters[name].estimate, fit.parameters[name].high]
            for name in result["true"]
        }
    if count > 1 and found.best.explains:
        result |= predicted(found, run, kind, sizes, laterals, random.uniform(*SPEEDS))
    return result


def predicted(found: Any, run: Passages, kind: str, sizes: list[float], laterals: list[float], speed: float) -> Any:
    """Force and stress at A1 at another speed, as predicted and as they are, medians over places."""
    forces, stresses = [], []
    for number in range(PLACES):
        block, row = hit(run, kind, sizes, laterals[number % len(laterals)], 0.6 * number / PLACES, speed)
        forces.append(block.forces[row - 300 : row + 1500, 0].max())
        stresses.append(block.max_principal[row - 300 : row + 1500, 0].max())
    (what,) = predict(found, [speed], passages=24)
    a1 = what.nodes["A1"]
    return {
        "force": [what.force.low, what.force.estimate, what.force.high, float(np.median(forces))],
        "A1": [a1.low, a1.estimate, a1.high, float(np.median(stresses))],
    }


def summary(results: list[dict[str, Any]]) -> str:
    """What came out, a line each."""
    lines = [f"{len(results)} cases"]
    for model in ("right", "off"):
        for count in (1, 3):
            part = [each for each in results if (each["model"], each["passages"]) == (model, count)]
            if not part:
                continue
            named = [each for each in part if "intervals" in each]
            told = [
                (low <= each["true"][name] <= high, abs(middle / each["true"][name] - 1), name)
                for each in named
                for name, (low, middle, high) in each["intervals"].items()
            ]
            lengths = [(inside, error) for inside, error, name in told if name.endswith("length_m")]
            lines.append(
                f"model {model}, {count} passages, {len(part)} cases: "
                f"kind right {np.mean([each['kind'] == each['found'] for each in part]):.0%}, "
                f"explained {np.mean([each['chi2_per_n'] <= 1.3 for each in part]):.0%}, "
                f"coverage {np.mean([inside for inside, *_ in told]):.0%} of {len(told)} sizes, "
                f"of lengths {np.mean([inside for inside, _ in lengths]):.0%}, "
                f"length error median {np.median([error for _, error in lengths]):.1%}, "
                f"90 % of cases {np.quantile([error for _, error in lengths], 0.9):.1%}, "
                f"largest {max(error for _, error in lengths):.1%}, "
                f"processor {np.median([each['cpu_s'] for each in part]):.1f} s, "
                f"up to {max(each['cpu_s'] for each in part):.1f} s"
            )
            after = [each for each in part if "force" in each]
            if after:
                errors = {name: [abs(each[name][1] / each[name][3] - 1) for each in after] for name in ("force", "A1")}
                words = (
                    f"{name} error median {np.median(of):.1%}, largest {max(of):.1%}" for name, of in errors.items()
                )
                lines.append(f"  predicted at another speed, {len(after)} cases: {', '.join(words)}")
    return "\n".join(lines)


def main() -> None:
    """Run the cases that are missing in the file, and print a summary of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=100, help="number of cases")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--out", type=Path, default=Path("identification.jsonl"))
    options = parser.parse_args()
    done = [json.loads(line) for line in options.out.read_text().splitlines()] if options.out.exists() else []
    there = {each["case"] for each in done}
    with options.out.open("a", encoding="utf-8") as file:
        for number in (each for each in range(options.first, options.first + options.cases) if each not in there):
            done.append(case(number))
            file.write(json.dumps(done[-1]) + "\n")
            file.flush()
    print(summary(done))


if __name__ == "__main__":
    main()
