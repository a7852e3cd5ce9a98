"""What a sample of a data set costs: ``python benchmarks/dataset.py [SPEC] [PASSAGES] [SEED]``.

Processor time of one process for passages of the specification, without what is built once. Beside it stands the factor
of smooth wheels measured in turn, by which machines and loads can be compared.
"""

from __future__ import annotations

import sys
import time

from wheelset_track_sim.dataset.labels import group
from wheelset_track_sim.dataset.passing import Passing, program, simulate
from wheelset_track_sim.dataset.spec import load_spec
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

TARGET = 0.18
"""s: 100,000 samples in five hours of a core."""


def main(name: str = "damaged_wheels", passages: str = "4", seed: str = "1") -> None:
    """Print processor seconds a sample, and what it is of the target."""
    spec, smooth = load_spec(name), Simulator(load_scenario("undamaged"))
    smooth.advance(27778)
    labels = [group(spec, int(seed), number, 10**6) for number in range(int(passages) + 1)]
    simulate(Passing(spec, tuple(labels.pop()[:2])), program())  # compiles, and loads models
    taken, samples, factors = 0.0, 0, []
    for each in labels:
        begun = time.process_time()
        simulate(Passing(spec, tuple(each)), program())
        ended = time.process_time()
        taken, samples = taken + ended - begun, samples + len(each)
        smooth.advance(27778)
        factors.append(1.0 / (time.process_time() - ended))
    factor = sorted(factors)[len(factors) // 2]
    print(f"{taken / samples:.3f} s a sample over {samples}, {taken / samples / TARGET:.2f} of {TARGET} s")
    print(f"smooth wheels meanwhile: {factor:.0f} times real time")
    print(f"100,000 samples: {taken / samples * 1e5 / 3600:.2f} core hours here")


if __name__ == "__main__":
    main(*sys.argv[1:])
