"""What a resimulation says: only of what it compared, and nothing of a run that was not simulated to its end."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from support.paths import OLD_BAG
from support.rewriting import entries_of, write
from wheelset_track_sim.bags import Bag, BagWriter, RunInfo, State
from wheelset_track_sim.cli import main
from wheelset_track_sim.cli.resimulate import as_mapping, verdict
from wheelset_track_sim.errors import InputError, InputWarning, recorded_input
from wheelset_track_sim.irregularities import Roughness
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin import resimulate
from wheelset_track_sim.twin.differences import RunDifferences


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bag") / "run.mcap"
    simulator = Simulator(load_scenario("undamaged"))
    with record(path, simulator) as push:
        for _ in range(3):
            block = simulator.advance(300)
            push(block, summarise(block))
    return path


def later(bag: Path, path: Path, steps: int) -> Path:
    """The bag with its samples so many steps later."""
    found = Bag(bag)
    with BagWriter(path, found.info, start_ns=0) as writer:
        for event in found.events():
            if isinstance(event, State):
                writer.write_state(event)
            else:
                writer.write(dataclasses.replace(event, first_step=event.first_step + steps))
    return path


def test_the_verdict_names_what_was_compared(bag: Path) -> None:
    found = resimulate(bag)
    assert found.nodes == ("A1", "B1", "C1")
    [line] = verdict(found)
    assert line.startswith(
        "Bit-identical: both contact forces and all stresses of A1, B1, C1 are the same to the last "
    )
    assert "in the 900 steps that were compared (0.0324 s)" in line


def test_signals_that_are_not_there_are_not_said_to_be_the_same(bag: Path, tmp_path: Path) -> None:
    entries, records = entries_of(bag)
    forces = [entry for entry in entries if "axle_stress" not in entry.topic]
    [line] = verdict(resimulate(write(tmp_path / "forces.mcap", forces, records)))
    assert line.startswith("Bit-identical: both contact forces and no stresses are the same")
    fewer = [entry for entry in entries if not entry.topic.endswith("/b1")]
    found = resimulate(write(tmp_path / "fewer.mcap", fewer, records), ["output.stress_nodes=[C1]"])
    assert found.nodes == ("C1",)
    assert as_mapping(found)["not_compared"] == ["stresses of A1, which the scenario does not have"]


def test_steps_that_are_lost_are_not_said_to_be_the_same(bag: Path, tmp_path: Path) -> None:
    entries, records = entries_of(bag)
    gone = next(entry for entry in entries if entry.topic.endswith("/c1") and entry.time_ns > entries[0].time_ns)
    lines = verdict(resimulate(write(tmp_path / "less.mcap", [e for e in entries if e is not gone], records)))
    assert any("incomplete without /wheelset_track_sim/axle_stress/c1" in line for line in lines)
    assert "in the 600 steps that were compared" in lines[-1]


def test_a_zero_has_two_signs(run_blocks: list[object]) -> None:
    differences = RunDifferences(("force",), 1.0)
    differences.push(run_blocks[0], 0, np.zeros((3, 1)), np.array([[0.0], [-0.0], [0.0]]))  # type: ignore[arg-type]
    assert differences.found is not None
    assert differences.found.first.step == 1


def test_a_bag_that_begins_far_from_its_start_is_refused_with_the_time_that_it_takes(bag: Path, tmp_path: Path) -> None:
    far = later(bag, tmp_path / "far.mcap", 10**12)
    with pytest.raises(InputError, match=r"step 1000000000000 comes 10{12} steps \(3.6e\+07 s .* about .* s here"):
        resimulate(far)
    with pytest.raises(InputError, match="give --most-steps 5000 to do so"):
        resimulate(later(bag, tmp_path / "near.mcap", 5000), most_steps=4999)
    assert main(["resimulate", str(far)]) == 2


def is_busy(pid: int) -> bool:
    """Whether a process has used a second of a processor: it has begun to work."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("command", [["resimulate"], ["replay", "--simulate-again"]])
def test_a_proof_that_is_interrupted_does_not_end_with_status_0(bag: Path, tmp_path: Path, command: list[str]) -> None:
    far = later(bag, tmp_path / "far.mcap", 10**12)
    arguments = [sys.executable, "-m", "wheelset_track_sim", *command, str(far), "--most-steps", str(10**13)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not is_busy(process.pid):
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    assert process.returncode in (1, -signal.SIGINT)  # the latter if it came while modules were imported
    assert out == ""
    assert "nterrupt" in err.splitlines()[-1]


def test_digests_of_the_first_version_are_not_compared_with_those_of_today() -> None:
    found = resimulate(OLD_BAG)
    assert found.digests_differ == "0.1.0"
    assert not found.origin.keys() & {"wheelset", "track"}
    lines = verdict(found)
    assert lines[-1].startswith("Recorded by version 0.1.0, whose digests have another form: they do not show whether")
    assert lines[-1].endswith("which the equal numbers show to be the same.") == found.identical


NARROW = ((0.01, 0.0), (0.02, 3.0))
"""A spectrum over a seventh of the band."""


def test_a_spectrum_that_fresh_input_may_not_have_is_simulated_as_it_was_recorded(tmp_path: Path) -> None:
    with recorded_input(), pytest.warns(InputWarning, match=r"as recorded: spectrum covers wavelengths from 0\.01"):
        rough = Roughness(on="wheel_1", spectrum=NARROW)
    with pytest.raises(InputError, match=r"spectrum covers wavelengths from 0\.01 to 0\.02 m"):
        Roughness(on="wheel_1", spectrum=NARROW)
    simulator = Simulator(dataclasses.replace(load_scenario("undamaged"), irregularities=(rough,)))
    path = tmp_path / "rough.mcap"
    with record(path, simulator) as push:
        block = simulator.advance(300)
        push(block, summarise(block))
    with pytest.warns(InputWarning, match="as recorded: spectrum"):
        assert resimulate(path).identical
    with pytest.warns(InputWarning, match="as recorded: spectrum"):
        assert not resimulate(path, ["axle_load=190e3"]).identical
    with pytest.warns(InputWarning), pytest.raises(InputError, match="spectrum covers wavelengths"):
        resimulate(path, ["irregularities.0.shortest=0.004"])


def test_what_a_fresh_scenario_is_warned_of_is_not_repeated_for_its_bag() -> None:
    spectrum = ((0.01, 0.0), (0.3, 3.0))
    with pytest.warns(InputWarning, match="its end levels are used"):
        Roughness(on="wheel_1", spectrum=spectrum)
    with warnings.catch_warnings(), recorded_input():
        warnings.simplefilter("error")
        Roughness(on="wheel_1", spectrum=spectrum)


def test_a_bag_of_an_unknown_version_explains_its_differences(bag: Path, tmp_path: Path) -> None:
    found = Bag(bag)
    info = RunInfo("undamaged", found.info.scenario, "", 0.6, versions={}, inputs=found.info.inputs)
    with BagWriter(tmp_path / "unknown.mcap", info, start_ns=0) as writer:
        for block in found.blocks():
            writer.write(dataclasses.replace(block, forces=block.forces + 1.0))
    again = resimulate(tmp_path / "unknown.mcap")
    assert not again.identical
    assert again.origin["wheelset_track_sim"][0] == "unknown"
    assert not again.unexplained
