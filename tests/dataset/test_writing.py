"""Data sets as a whole: smooth track and short samples, so that a passage takes little."""

import dataclasses
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.cli import main
from wheelset_track_sim.dataset import DatasetSpec, rebuild, write_dataset
from wheelset_track_sim.dataset.labels import group
from wheelset_track_sim.dataset.passing import Passing, program, simulate
from wheelset_track_sim.dataset.writing import stored
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.schema import read
from wheelset_track_sim.inputs.yaml12 import dump
from wheelset_track_sim.studies import Resources

parquet = pytest.importorskip("pyarrow.parquet", reason="the extra analysis brings pyarrow")
SPEC = {
    "title": "Short",
    "licence": "CC0-1.0",
    "duration": 0.1,
    "speed": {"distribution": "uniform", "low": 28.0, "high": 32.0},
    "rail_roughness": None,
    "pad_scatter": 0.0,
    "ballast_scatter": 0.0,
    "wheelsets": 2,
    "damage": [{"type": "none"}, {"type": "flat"}, {"type": "breakout"}, {"type": "worn_flat"}],
}


def files(folder):
    """Content of all files below a folder, by name."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "one.zarr"
    card = write_dataset(read(DatasetSpec, SPEC, ""), folder, samples=4, seed=4, resources=Resources(workers=2))
    return folder, card


@pytest.mark.slow
def test_labels_and_card_say_what_is_there(written):
    folder, card = written
    table = parquet.read_table(folder / "labels.parquet").to_pydict()
    assert table["sample"] == [*range(4)]
    assert set(table["damage"]) <= {"none", "flat", "breakout", "worn_flat"}
    assert (card["samples"], card["seed"], card["failed"]) == (4, 4, 0)
    assert card["arrays"]["contact_force"]["shape"] == [4, 2, 1000]
    assert card["arrays"]["contact_force"]["channels"] == ["wheel_1", "wheel_2"]
    assert sum(of["samples"] for of in card["splits"].values()) == 4
    assert 28.0 <= card["ranges"]["speed"][0] <= card["ranges"]["speed"][1] <= 32.0
    text = (folder / "README.md").read_text()
    assert "Licence: CC0-1.0" in text
    for sample in range(4):
        found = stored(folder, sample)
        assert np.isfinite(found["axle_box_acceleration"]).all()
        hit = table["damaged_wheel"][sample] or "none"
        peaks = found["contact_force"].max(axis=1) / (table["axle_load"][sample] / 2)
        assert np.all(peaks > 1.3) or hit == "none" or peaks[int(hit[-1]) - 1] == peaks.max()


@pytest.mark.slow
def test_a_sample_is_rebuilt_from_its_label_bit_for_bit(written):
    folder, _ = written
    again, there = rebuild(folder, 3), stored(folder, 3)
    assert again.keys() == there.keys()
    assert all(again[name].tobytes() == there[name].tobytes() for name in again)


@pytest.mark.slow
def test_a_killed_data_set_goes_on_where_it_was_on_dask_with_the_same_bytes(written, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra dask brings distributed")
    folder, _ = written
    (tmp_path / "spec.yaml").write_text(dump(SPEC))
    command = [sys.executable, "-m", "wheelset_track_sim", "dataset", str(tmp_path / "spec.yaml")]
    command += ["--samples", "4", "--seed", "4", "--out", str(tmp_path / "killed.zarr"), "--workers", "1"]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL, start_new_session=True)
    first = tmp_path / "killed.zarr" / "peak_force" / "c" / "0" / "0"
    while not first.exists() and process.poll() is None:
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert first.exists()
    assert not (tmp_path / "killed.zarr" / "labels.parquet").exists()
    begun = first.stat().st_mtime_ns
    with pytest.raises(InputError, match=r"is no complete data set .*: give one with a card.json"):
        rebuild(tmp_path / "killed.zarr", 0)
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as here:
        resources = Resources(scheduler=here.scheduler_address)
        write_dataset(read(DatasetSpec, SPEC, ""), tmp_path / "killed.zarr", samples=4, seed=4, resources=resources)
    assert first.stat().st_mtime_ns == begun
    assert files(tmp_path / "killed.zarr") == files(folder)


@pytest.mark.slow
def test_the_command_rebuilds_and_says_what_differs(written, tmp_path, capsys):
    folder, _ = written
    assert main(["dataset", str(folder), "--rebuild", "1"]) == 0
    assert "is the same in all bits" in capsys.readouterr().out
    assert main(["dataset", str(folder), "--rebuild", "4"]) == 2
    assert "sample = 4 is out of range" in capsys.readouterr().err
    assert main(["dataset", "damaged_wheels", "--samples", "3"]) == 2
    assert capsys.readouterr().err == (
        "wheelset-track-sim: --out is missing: give --samples N and --out DIR, or --rebuild SAMPLE\n"
    )


@pytest.mark.slow
def test_damage_is_seen_at_the_box_of_its_wheel_and_noise_changes_with_its_seed():
    spec = read(DatasetSpec, SPEC | {"damage": [{"type": "flat", "length": 0.05}], "wheel_roughness": None}, "")
    first, second = group(spec, 1, 0, 2)
    noisier = dataclasses.replace(first, sample=1, noise_seed=first.noise_seed + 1)
    found = simulate(Passing(spec, (first, noisier, second)), program())
    for row, label in ((0, first), (2, second)):
        peaks = np.abs(found["axle_box_acceleration"][row]).max(axis=1)
        assert peaks.argmax() == int(label.damaged_wheel[-1]) - 1
    assert np.array_equal(*found["contact_force"][:2])
    difference = np.subtract(*found["axle_box_acceleration"][:2])
    assert difference.std() == pytest.approx(np.sqrt(2) * 2.0, rel=0.1)


@pytest.mark.slow
def test_a_detector_reads_the_load_of_both_wheels_while_they_are_over_it():
    changes = {"damage": [{"type": "none"}], "detector": "shear_single", "detector_noise": 0.0, "joint": {"share": 0.0}}
    spec = read(DatasetSpec, SPEC | changes | {"wheel_roughness": None, "duration": 0.15}, "")
    label = group(spec, 1, 0, 1)[0]
    read_out = simulate(Passing(spec, (label,)), program())["wayside/shear_single"][0]
    known = np.isfinite(read_out[0])
    assert read_out.shape == (2, spec.detector_samples)
    assert known.sum() > 0.8 * read_out.shape[1]
    assert known[: known.sum()].all()
    over = read_out[:, read_out[0] > 0.25 * label.axle_load]
    assert over.mean(axis=1) == pytest.approx(label.axle_load / 2, rel=0.03)
    assert np.abs(read_out[:, 0]) == pytest.approx(0.0, abs=0.05 * label.axle_load)


def test_another_program_is_refused():
    spec = read(DatasetSpec, SPEC, "")
    with pytest.raises(Exception, match="this worker runs another version of the program"):
        simulate(Passing(spec, tuple(group(spec, 1, 0, 2))), "other")
