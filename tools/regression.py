"""Whether the shipped scenarios still have the forces and stresses that they had.

``python -m tools.regression`` stores the numbers that ``tests/regression`` compares, for a change that is meant to
change them. ``python -m tools.regression OTHER`` compares this checkout with another one, bit for bit: it runs every
shipped scenario by the command line of both, and compares all samples of both bags. Each builds its own models.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from support.shipped_runs import REFERENCE, STEPS, numbers_of, text_of  # noqa: E402


def main() -> int:
    """Store the numbers, or compare with another checkout; 1 if a bit differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, nargs="?", help="folder of another checkout")
    parser.add_argument("scenarios", nargs="*", help="shipped scenarios; all if none is given")
    given = parser.parse_args()
    if given.other is None:
        REFERENCE.parent.mkdir(exist_ok=True)
        REFERENCE.write_text(text_of({name: numbers_of(name) for name in shipped.names("scenarios")}), encoding="utf-8")
        print(f"{REFERENCE.relative_to(ROOT)} is written")
        return 0
    return compare(given.other.resolve(), given.scenarios or shipped.names("scenarios"))


def compare(other: Path, names: list[str]) -> int:
    """Print for each scenario whether both checkouts agree; 1 if one does not."""
    different = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            found = [arrays_of(root, name, Path(folder) / side) for side, root in (("here", ROOT), ("there", other))]
            differences = [
                f"{kind} by up to {np.abs(here - there).max():.3g} {unit}"
                for kind, unit, here, there in zip(("forces", "stresses"), ("N", "Pa"), *found, strict=True)
                if not np.array_equal(here, there)
            ]
            different += bool(differences)
            print(f"{name}: {'; '.join(differences) or 'equal'}", flush=True)
    print(f"{len(names) - different} of {len(names)} scenarios are equal bit for bit")
    return int(different > 0)


def arrays_of(root: Path, name: str, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Forces and stresses of a run by the command line of a checkout, with its models in ``folder``."""
    folder.mkdir(exist_ok=True)
    bag = folder / f"{name}.mcap"
    duration = (STEPS - 0.5) * load_scenario(name).step_period
    done = subprocess.run(
        [sys.executable, "-m", "wheelset_track_sim", "run", name, "--duration", str(duration), "--out", bag, "--json"],
        env={**os.environ, "WHEELSET_TRACK_SIM_CACHE": str(folder), "PYTHONPATH": str(root)},
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        sys.exit(f"{name} does not run in {root}: {done.stderr}")
    recording = read_bag(bag)
    return recording.forces, recording.stresses


if __name__ == "__main__":
    sys.exit(main())
