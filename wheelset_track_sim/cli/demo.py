"""``demo``: the paper's Section 5.1 from the models to a recorded stream, a picture and a table."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

from ..errors import WheelsetTrackError
from ..scenario import load_scenario
from ..simulation.simulator import Simulator
from .console import terminal
from .progress import shown
from .report import report

SCENARIO = "damage_wheel_1"
DURATION = 5.0
"""Simulated time, s, streamed in real time."""
PATIENCE = 120.0
"""Bound on the node's run, s."""


def demo(out: Path) -> int:
    """Build the models, stream and record through the node, draw and print; returns the exit status."""
    console = terminal()
    bag = out / time.strftime("run_%Y%m%d_%H%M%S")
    with shown() as progress:
        Simulator(load_scenario(SCENARIO), progress)  # the node then finds the models in the cache
    out.mkdir(parents=True, exist_ok=True)
    console.print(
        f"streaming {SCENARIO} for {DURATION:g} s through the ROS 2 node, recording to {bag}", highlight=False
    )
    command = [sys.executable, "-m", "wheelset_track_sim", "node", "--ros-args", "--log-level", "warn"]
    for parameter in (
        f"scenario:={SCENARIO}",
        f"duration:={DURATION}",
        "real_time_factor:=1.0",
        "record.on_start:=true",
        f"record.directory:={out}",
        f"record.name:={bag.name}",
    ):
        command += ["-p", parameter]
    try:
        status = subprocess.run(command, timeout=PATIENCE, env=dict(os.environ), check=False).returncode
    except subprocess.TimeoutExpired:
        raise WheelsetTrackError(f"the node did not stop within {PATIENCE:g} s: see its messages above") from None
    if status != 0:
        raise WheelsetTrackError(f"the node ended with status {status}: see its messages above")
    return report(bag, None)
