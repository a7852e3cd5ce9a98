import os
import subprocess
import sys
from pathlib import Path

import pytest

from wheelset_track_sim.runtime import jit
from wheelset_track_sim.simulation.models import KERNELS

SIMULATE = """
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.coupled_kernels import run
from wheelset_track_sim.simulation.simulator import Simulator
Simulator(load_scenario("{scenario}")).advance(10)
print(sum(run.stats.cache_hits.values()), sum(run.stats.cache_misses.values()))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("kernels", "scenario"), [("causal", "damage_wheel_1"), ("line", "scattered_support")])
def test_a_simulation_finds_all_of_its_step_compiled(tmp_path: Path, kernels: str, scenario: str) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-m", KERNELS, kernels], env=environment, check=True, capture_output=True)
    assert len(list(tmp_path.glob(f"kernels/*/{jit.DONE}-{kernels}"))) == 1
    simulate = SIMULATE.format(scenario=scenario)
    found = subprocess.run(
        [sys.executable, "-c", simulate], env=environment, check=True, capture_output=True, text=True
    )
    assert found.stdout.split() == ["1", "0"]
