"""The commands of the README for ROS 2 users, word by word, as a bash script.

    set -eo pipefail -m
    eval "$(python3 tools/readme_ros2.py install launch talk)"

``install`` makes a workspace of the folder at hand, ``launch`` starts the launch file, ``talk`` is the second terminal.
Commands that never end by themselves run in the background, or until they have printed a line; answers of the node are
read, because the tools of ROS 2 end with 0 when the node refuses. ``.ci/ros2`` runs all of it in a container.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"
BLOCKS = {"install": "rosdep install", "launch": "rosdep install", "talk": "ros2 topic echo"}
"""A command of the block in which the commands of each part are."""
LAUNCH = "ros2 launch "
BACKGROUND = {LAUNCH: "launch", "ros2 run wheelset_track_sim node": "node"}
"""Commands that run until they are interrupted, by their beginnings, with the name under which they do."""
AFTER = {"node": "launch"}
"""What is interrupted before another node of the same name begins."""
CHECKED = {
    "ros2 topic echo ": "first_line",
    "ros2 service call ": "says success=True",
    "ros2 param set ": "says successful",
}
"""Functions below that run other commands, by the beginnings of these."""
FUNCTIONS = r"""
declare -A running
sudo() { if [ "$(id -u)" = 0 ]; then "$@"; else command sudo "$@"; fi; }
step() { printf '\n== %s\n' "$*"; }
# Start a command under a name; -m gives it a process group of its own, and Ctrl-C as in a terminal.
background() {
  local name=$1
  shift
  "$@" >"$name.log" 2>&1 &
  running[$name]=$!
  trap 'cat -- *.log; for group in "${running[@]}"; do kill -KILL -- "-$group" 2>/dev/null || true; done' EXIT
}
# Wait until a command in the background streams, end it by Ctrl-C, and require that it ends with 0.
interrupt() {
  for _ in $(seq 900); do
    if grep -q streaming "$1.log"; then break; fi
    kill -0 "${running[$1]}"
    sleep 1
  done
  kill -INT -- "-${running[$1]}"
  wait "${running[$1]}"
  unset "running[$1]"
}
# Run a command until it prints a line; again while the node is not there yet.
first_line() {
  local found
  for _ in $(seq 90); do
    found=$(timeout --signal=INT 30 "$@" 2>&1 | grep -m 1 -E '^[-0-9]' || true)
    if [ -n "$found" ]; then
      echo "$found"
      return
    fi
    sleep 1
  done
  echo "no line from: $*" >&2
  return 1
}
# Require that a command prints some words.
says() {
  local words=$1 found
  shift
  found=$("$@")
  echo "$found"
  grep -q "$words" <<<"$found"
}
"""


def commands(part: str, text: str) -> list[str]:
    """Commands of a part as the README has them, without comments."""
    section = re.split(r"(?m)^## ", text.partition("\n## ROS 2\n")[2])[0]
    blocks = re.findall(r"(?m)(?:^    \S.*\n)+", section)
    [block] = [block for block in blocks if BLOCKS[part] in block]
    found = [re.sub(r"\s+# .*", "", line.strip()) for line in block.splitlines()]
    return found if part == "talk" else [line for line in found if line.startswith(LAUNCH) == (part == "launch")]


def script(part: str, text: str) -> str:
    """Bash script of a part, without ``FUNCTIONS``."""
    lines = []
    for command in commands(part, text):
        name = next((name for beginning, name in BACKGROUND.items() if command.startswith(beginning)), None)
        check = next((check for beginning, check in CHECKED.items() if command.startswith(beginning)), None)
        by = f"background {name}" if name else check
        lines.append("step '" + command.replace("'", "'\\''") + "'")
        if name in AFTER:
            lines.append(f"interrupt {AFTER[name]}")
        lines.append(f"{by} {command}" if by else command)
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    readme = README.read_text(encoding="utf-8")
    sys.stdout.write("\n".join([FUNCTIONS, *(script(part, readme) for part in sys.argv[1:])]))
