from pathlib import Path

from setuptools import setup

SHARE = "share/wheelset_track_sim"


def files(folder: str, pattern: str) -> list[str]:
    return sorted(str(path) for path in Path(folder).glob(pattern))


# Everything else is in setup.cfg. `node` is no console script, for in an activated environment it would hide Node.js;
# in lib/wheelset_track_sim it is found by `ros2 run wheelset_track_sim node`, and `replay` likewise.
setup(
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/wheelset_track_sim"]),
        (SHARE, ["package.xml"]),
        (f"{SHARE}/launch", files("launch", "*.launch.py")),
        (f"{SHARE}/config", files("config", "*.yaml")),
        (f"{SHARE}/config/layouts", files("config/layouts", "*")),
        (f"{SHARE}/config/sros2", files("config/sros2", "*.xml")),
        ("lib/wheelset_track_sim", ["tools/node", "tools/replay"]),
    ],
)
