"""A Dask cluster of a scheduler and two workers, in processes of their own, gives what this machine gives."""

import os
import subprocess
import sys
import time
from typing import Any

import pytest

from wheelset_track_sim.cli import main

EVALUATE = "wheelset_track_sim.studies.evaluate"


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Address of a scheduler with two workers, which the first test finds new."""
    distributed = pytest.importorskip("distributed")
    folder = tmp_path_factory.mktemp("cluster")
    contact = folder / "scheduler.json"
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    options: Any = {"stdout": subprocess.DEVNULL, "stderr": (folder / "dask.log").open("w"), "env": environment}
    dask = [sys.executable, "-m", "dask"]
    processes = [
        subprocess.Popen(
            [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", contact],
            **options,
        )
    ]
    worker = ["worker", "--scheduler-file", contact, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    try:
        deadline = time.monotonic() + 60
        while not contact.exists():
            assert time.monotonic() < deadline
            time.sleep(0.05)
        processes += [subprocess.Popen([*dask, *worker, "--name", name], **options) for name in ("one", "two")]
        with distributed.Client(scheduler_file=str(contact), timeout=60) as client:
            client.wait_for_workers(2, timeout=120)
            yield client.scheduler.address, client
    finally:
        for process in processes:
            process.kill()
            process.wait()
        options["stderr"].close()


@pytest.mark.slow
def test_a_cluster_gives_the_same_table_as_this_machine(cluster, small, study_file, tmp_path, capsys) -> None:
    address, client = cluster
    path = study_file(small)
    worked: Any = lambda: EVALUATE in sys.modules  # noqa: E731  a lambda goes to the workers with its code
    assert list(client.run(worked).values()) == [False, False]
    assert main(["study", path, "--out", str(tmp_path / "here"), "--workers", "1"]) == 0
    assert main(["study", path, "--out", str(tmp_path / "there"), "--scheduler", address]) == 0
    here, there = ((tmp_path / name / "results.csv").read_text() for name in ("here", "there"))
    assert there == here
    assert here.count("\n") == 5
    assert list(client.run(worked).values()) == [True, True]


@pytest.mark.slow
def test_a_failing_run_on_a_cluster_is_told(cluster, small, study_file, tmp_path, capsys) -> None:
    small["vary"] = {"case": {"good": {}, "too long": {"dynamics": "paper", "speed": 5.0}}}
    small["window"] = {"before": 0.1, "after": 60.0}  # beyond the 11 s of paper dynamics at this speed
    out = tmp_path / "out"
    assert main(["study", study_file(small), "--out", str(out), "--scheduler", cluster[0]]) == 1
    assert "1 run failed" in capsys.readouterr().err
    assert len(list((out / "runs").glob("*.npz"))) == 1


def test_no_scheduler_is_told_in_one_line(small, study_file, tmp_path, capsys, monkeypatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("wheelset_track_sim.studies.workers.CONNECT", "1s")
    arguments = ["study", study_file(small), "--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:9"]
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert "--scheduler tcp://127.0.0.1:9 does not answer" in told
    assert told.strip().count("\n") == 0
