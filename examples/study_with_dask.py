"""Run a study on a Dask cluster, and read its results.

    .venv/bin/python examples/study_with_dask.py [ADDRESS]

ADDRESS is that of a scheduler, such as tcp://10.0.0.5:8786; without it, the script starts a cluster of two workers on
this machine. Finished runs are stored in the folder `flats`, so a second call has nothing to simulate.
It needs the extra `dask` (`python3 tools/setup_env.py dask`).
"""

import sys

from distributed import LocalCluster

import wheelset_track_sim as wts
from wheelset_track_sim.studies import Resources

STUDY = wts.Study(
    title="Fresh flats",
    scenario="flat_fresh",
    vary={"irregularities.0.length": [0.03, 0.05]},  # m
    outputs=("wheels.wheel_1.max_force", "nodes.A1.max_principal"),
)


def main(address: str) -> None:
    """Run the study by the scheduler at an address, and print its results."""
    results = wts.run_study(STUDY, "flats", resources=Resources(scheduler=address))
    for index, run in enumerate(results.runs):
        force, stress = (results.value(index, output) for output in STUDY.outputs)
        print(f"{run.label}: {force / 1e3:.0f} kN, {stress / 1e6:.1f} MPa")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(sys.argv[1])
    else:
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            main(cluster.scheduler_address)
