"""Bags after a power failure: of each file what was synced, under the names that were synced, and junk after it."""

import os
from pathlib import Path

import numpy as np
import pytest

from support.blocks import RUN_INFO, block_of_numbers, state_of_numbers
from wheelset_track_sim.bags import BagWriter, read_bag
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.bags.settings import RecordSettings

CHUNK = 2778
"""Steps of 0.1 s."""


class Disk:
    """What a power failure leaves of a folder, by the calls that wait for the disk and by nothing else."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._contents: dict[int, bytes] = {}
        self._names: dict[Path, dict[str, int]] = {}
        for name in ("fsync", "fdatasync"):
            monkeypatch.setattr(os, name, self._sync)

    def _sync(self, opened: int) -> None:
        path = Path(f"/proc/self/fd/{opened}").readlink()
        if path.is_dir():
            self._names[path] = {each.name: each.stat().st_ino for each in path.iterdir()}
        else:
            self._contents[path.stat().st_ino] = path.read_bytes()

    def leave(self, folder: Path, to: Path, tail: str) -> None:
        """Write what is left; what was not synced is cut off, is zeros, or is half there and half zeros."""
        to.mkdir()
        for name, number in self._names.get(folder, {}).items():
            now = folder / name
            if now.is_dir():
                self.leave(now, to / name, tail)
                continue
            synced = self._contents.get(number, b"")
            lost = now.read_bytes()[len(synced) :] if now.exists() and now.stat().st_ino == number else b""
            kept = {"cut": 0, "zeros": 0, "half": len(lost) // 2}[tail]
            rest = b"" if tail == "cut" else bytes(len(lost) - kept)
            (to / name).write_bytes(synced + lost[:kept] + rest)


def steps_of(path: Path) -> np.ndarray:
    """Steps that a bag, damaged or not, has forces of."""
    return read_bag(path, lost=lambda _: None).steps


@pytest.mark.parametrize("tail", ["cut", "zeros", "half"])
@pytest.mark.parametrize("name", ["run", "run.mcap"])
def test_what_was_synced_is_there_after_a_power_failure(tmp_path, monkeypatch, name, tail):
    disk = Disk(monkeypatch)
    folder, split = tmp_path / "bags", name == "run"
    folder.mkdir()
    settings = RecordSettings(max_duration=1.0) if split else None
    writer = BagWriter(folder / name, RUN_INFO, start_ns=1_700_000_000 * 10**9, settings=settings)
    time = 0.0
    for number in range(24):
        block = block_of_numbers(number * CHUNK, CHUNK, time=time)
        time += CHUNK * block.step_period
        if number == 0:
            writer.write_state(state_of_numbers(block))
        writer.write(block)
        if number % 7 == 6:
            writer.sync()
            promised = steps_of(folder / name)
            assert len(promised) > (number - 1) * CHUNK  # at most 0.1 s has not been flushed
        if number % 7 in (3, 6) and number >= 6:
            left = tmp_path / f"left_{number}"
            disk.leave(folder, left, tail)
            found = steps_of(recover(left / name, left / "recovered").path if number % 2 else left / name)
            assert np.isin(promised, found).all()
    writer.close(sync=True)
    disk.leave(folder, tmp_path / "left", tail)
    assert len(read_bag(tmp_path / "left" / name).steps) == 24 * CHUNK  # whole: nothing is lost, or it would raise
