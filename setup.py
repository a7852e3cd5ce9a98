import os
import re
from pathlib import Path

from setuptools import setup

SHARE = "share/wheelset_track_sim"
REPOSITORY = os.environ.get("WHEELSET_TRACK_SIM_REPOSITORY", "")
"""Address of the repository, such as https://github.com/OWNER/NAME, for links; the release workflow sets it."""


def files(folder: str, pattern: str) -> list[str]:
    return sorted(str(path) for path in Path(folder).glob(pattern))


def readme() -> str:
    """README for readers elsewhere: links into the repository are absolute, or plain text if its address is unknown."""

    def elsewhere(link: re.Match[str]) -> str:
        image, text, target = link.groups()
        if not REPOSITORY:
            return "" if image else text
        page = f"README.md{target}" if target.startswith("#") else target
        return f"{image}[{text}]({REPOSITORY}/{'raw' if image else 'blob'}/HEAD/{page})"

    return re.sub(r"(!?)\[([^\]]*)\]\((?!https?:)([^)\s]+)\)", elsewhere, Path("README.md").read_text(encoding="utf-8"))


# Everything else is in setup.cfg. python_requires is here, as text: in setup.cfg it becomes an object, which colcon
# cannot read. `node` is no console script, because it would hide Node.js in an activated environment; `ros2 run
# wheelset_track_sim node` finds it in lib/wheelset_track_sim, and `replay` likewise.
setup(
    python_requires=">=3.10",
    long_description=readme(),
    project_urls={
        name: REPOSITORY + path
        for name, path in (
            ("Source", ""),
            ("Documentation", "/tree/HEAD/docs"),
            ("Changelog", "/blob/HEAD/CHANGELOG.md"),
            ("Issues", "/issues"),
        )
        if REPOSITORY
    },
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
