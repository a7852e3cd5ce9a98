"""Keep the fatigue of 1,000 axles by detector passages, without a simulation for each of them.

    .venv/bin/python examples/fleet_by_passage.py [WHEELSETS] [DAYS] [TABLE]

Flats of random length form on some wheelsets and grow. Each day each wheelset passes a detector, which reads the peak
force of one turn. From it, and from speed and load, follow the length of the flat and the damage of the axle over the
distance of the day. Both come from one table, which is built once by all cores and kept in the file TABLE.
"""

import sys
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import wheelset_track_sim as wts
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.studies.damage_table import DamageTable, build_damage_table, load_damage_table

SIZES = (0.0, 0.02, 0.03, 0.04, 0.05, 0.06)  # m
SPEEDS = tuple(speed / 3.6 for speed in (60, 70, 80, 90, 100, 110, 120))
LOADS = tuple(9810.0 * tonnes for tonnes in (10, 16, 22))
DAILY = 300e3  # m
NOISE = 0.03  # of a reading


def main(wheelsets: str = "1000", days: str = "100", file: str = "flats.npz") -> dict[str, float]:
    """Build or load the table, follow the fleet, and print what came out."""
    if not Path(file).exists():
        begun = time.perf_counter()
        scenario = wts.load_scenario("flat_fresh")
        table = build_damage_table(
            scenario, "irregularities.0.length", SIZES, SPEEDS, LOADS, load_curve("assumed_body")
        )
        table.save(file)
        print(f"table of {table.peaks[..., 0].size} runs of 500 m built in {time.perf_counter() - begun:.0f} s")
    table = load_damage_table(file)
    random, count = np.random.default_rng(1), int(wheelsets)
    lengths = np.where(random.random(count) < 0.2, random.uniform(0.02, 0.03, count), 0.0)
    true, ledger, inside, flats = np.zeros(count), np.zeros(count), 0, 0
    taken = 0.0
    for _ in range(int(days)):
        formed = random.random(count) < 0.001
        lengths = np.where(formed, random.uniform(0.02, 0.04, count), np.minimum(lengths * 1.003, SIZES[-1]))
        speeds, loads = random.uniform(SPEEDS[0], SPEEDS[-1], count), random.uniform(LOADS[0], LOADS[-1], count)
        low, high = table.peak_of(lengths, speeds, loads)[:, ::2].T
        read = random.uniform(low, high) * (1 + NOISE * random.standard_normal(count))
        true += DAILY * table.damage_of(lengths, speeds, loads)[:, 0]
        begun = time.process_time()
        for axle in range(count):  # one passage after the other, as they come in
            found = table.size_of(read[axle], speeds[axle], loads[axle], NOISE)
            ledger[axle] += DAILY * table.damage_of(found.estimate, speeds[axle], loads[axle])[0]
            flats += lengths[axle] > 0
            inside += lengths[axle] > 0 and found.low <= lengths[axle] <= found.high
        taken += time.process_time() - begun
    passages = count * int(days)
    damaged = lengths > 0
    result = {
        "passages_a_second": passages / taken,
        "ledger_to_true": float(ledger[damaged].sum() / true[damaged].sum()),
        "damaged_to_sound": float(true[damaged].mean() / true[~damaged].mean()),
        "inside": inside / flats,
    }
    print(f"{passages} passages of {count} wheelsets: {result['passages_a_second']:.0f} a second on one core")
    print(f"{damaged.sum()} with flats: {result['damaged_to_sound']:.1f} times the damage of sound ones at A1")
    print(f"ledger: {result['ledger_to_true']:.2f} of their true damage; {100 * result['inside']:.0f} % of the "
          "intervals hold the length")  # fmt: skip
    draw(table, 1e3 * lengths, true, ledger)
    return result


def draw(table: DamageTable, lengths: np.ndarray, true: np.ndarray, ledger: np.ndarray) -> None:
    """Write fleet.png: damage over length, mm, and speed beside sound wheels; the ledger over the true damage."""
    figure = Figure(figsize=(9.6, 3.9), dpi=125, layout="constrained")
    of_table, of_fleet = figure.subplots(1, 2)
    middle = len(table.loads) // 2
    ratio = table.damage[:, :, middle, 0] / table.damage[0, :, middle, 0]
    mesh = of_table.contourf(3.6 * table.speeds, 1e3 * table.sizes, ratio, 12)
    figure.colorbar(mesh, ax=of_table, label="damage a kilometre over that of sound wheels, A1")
    of_table.set_xlabel("speed (km/h)")
    of_table.set_ylabel("length of the flat (mm)")
    of_table.set_title(f"Table at {table.loads[middle] / 9810:.3g} t", fontsize=10, loc="left")
    sound = true[lengths == 0.0].mean()
    marks = of_fleet.scatter(true / sound, ledger / sound, c=lengths, s=8, cmap="viridis")
    figure.colorbar(marks, ax=of_fleet, label="length at the end (mm)")
    most = float((true / sound).max())
    of_fleet.plot([0, most], [0, most], color="#888888", linewidth=0.8)
    of_fleet.set_xlabel("true damage, sound wheelsets 1")
    of_fleet.set_ylabel("ledger")
    of_fleet.set_title(f"{len(true)} wheelsets", fontsize=10, loc="left")
    figure.savefig("fleet.png")


if __name__ == "__main__":
    main(*sys.argv[1:])
