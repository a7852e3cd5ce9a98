"""``init``: a copy of a shipped file to edit."""

from __future__ import annotations

from pathlib import Path

from ..inputs import shipped
from ..runtime.output_files import require_new
from .console import terminal

NEXT = {
    "scenarios": "run {file}",
    "studies": "study {file}",
    "wheelsets": "run undamaged --set wheelset={file} --set output.stress_nodes=[A1]",
    "tracks": "run undamaged --set track={file}",
    "vehicles": "run undamaged --set vehicle={file}",
    "detectors": "wayside damage_wheel_1 --detector {file}",
    "limits": "run damage_wheel_1 --limits {file}",
    "missions": "fatigue damage_wheel_1 --mission {file}",
    "datasets": "dataset {file} --samples 64 --seed 1 --out damage.zarr",
    "woehler": "fatigue damage_wheel_1 --curve {file}",
    "criteria": "fatigue press_fit --criterion {file}",
    "cracks": "crack damage_wheel_1 --depth '2 mm' --growth {file}",
}
"""Commands that use a file of a kind."""


def init(kind: str, name: str, out: Path | None, program: str, *, overwrite: bool) -> int:
    """Copy a shipped file, say how to use it; returns the exit status.

    Raises InputError for a kind or name that is not shipped, and a file that exists already.
    """
    folder = shipped.kind_of(kind)
    text = shipped.text(folder, name)
    copy = out or Path(f"{name}.yaml")
    require_new([copy], overwrite=overwrite)
    copy.write_text(text, encoding="utf-8")
    use = f": edit it, then {program} {NEXT[folder].format(file=copy)}" if folder in NEXT else ""
    terminal().print(f"{shipped.singular(folder)} {copy}{use}", highlight=False, soft_wrap=True)
    return 0
