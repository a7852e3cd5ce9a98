"""``cache`` on the command line, with models and compiled functions in folders of their own."""

import ast
import json
import os
import subprocess
import sys
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import pytest

from support.paths import ROOT
from wheelset_track_sim.cli.cache import HOLDS

FILL = """
from wheelset_track_sim.samples.principal import principal
from wheelset_track_sim.track.ring import track_ring
from wheelset_track_sim.track.track import load_track
for bays in (10, 12):
    track_ring(load_track("ballasted_60e1"), 0.01, bays=bays, max_frequency=100.0)
principal([1.0, 2.0, 3.0, 0.0, 0.0, 0.0])
"""


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    own = {"WHEELSET_TRACK_SIM_CACHE": str(tmp_path / "models"), "NUMBA_CACHE_DIR": str(tmp_path)}
    return os.environ | own


def python(environment: dict[str, str], *arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, *arguments], env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )


def cache(environment: dict[str, str], *options: str) -> dict[str, Any]:
    done = python(environment, "-m", "wheelset_track_sim", "cache", "--json", *options)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def counts(rows: list[dict[str, Any]]) -> dict[str, int]:
    return {row["kind"]: row["entries"] for row in rows if row["entries"]}


@pytest.mark.slow
def test_the_cache_is_listed_and_cleared(environment: dict[str, str], tmp_path: Path) -> None:
    begun = datetime.now(timezone.utc).replace(microsecond=0)
    assert python(environment, "-c", FILL).returncode == 0
    found = cache(environment)
    assert found["folders"] == {"models": str(tmp_path / "models"), "kernels": str(tmp_path / "kernels")}
    assert counts(found["kinds"]) == {"track": 2, "kernels": 1}
    [track] = [row for row in found["kinds"] if row["kind"] == "track"]
    assert track["size_bytes"] == sum(path.stat().st_size for path in (tmp_path / "models").iterdir())
    assert found["size_bytes"] == sum(row["size_bytes"] for row in found["kinds"]) > track["size_bytes"]
    assert begun <= datetime.fromisoformat(track["last_use"]) <= datetime.now(timezone.utc)

    shown = python(environment, "-m", "wheelset_track_sim", "cache").stdout
    assert str(tmp_path / "models") in shown
    assert "rings of sleeper bays" in shown

    removed = cache(environment, "--clear", "track")
    assert counts(removed["removed"]) == {"track": 2}
    assert removed["size_bytes"] == track["size_bytes"]
    assert counts(cache(environment)["kinds"]) == {"kernels": 1}
    assert counts(cache(environment, "--clear")["removed"]) == {"kernels": 1}
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    assert cache(environment)["size_bytes"] == 0


@pytest.mark.slow
def test_a_kind_that_is_not_known_is_refused(environment: dict[str, str]) -> None:
    done = python(environment, "-m", "wheelset_track_sim", "cache", "--clear", "tracks")
    assert done.returncode == 2
    assert done.stderr == (
        "wheelset-track-sim: --clear tracks is not a known kind of cache: did you mean track? known are all, wheelset, "
        "track, moving-track, moving-green, force-tables, kernels\n"
    )


@pytest.mark.slow
def test_every_kind_of_model_is_described() -> None:
    calls = [
        node
        for path in (ROOT / "wheelset_track_sim").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "cached"
    ]
    assert {call.args[0].value for call in calls if isinstance(call.args[0], ast.Constant)} | {"kernels"} == set(HOLDS)
