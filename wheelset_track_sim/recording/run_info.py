"""What a bag says about its run, beside the samples."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from importlib.metadata import version

from .. import __version__

METADATA_NAME = "wheelset_track_sim"


def versions() -> dict[str, str]:
    """Versions of the software that decides the numbers of a run."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    return {"wheelset_track_sim": __version__, "python": platform.python_version(), **libraries}


@dataclass(frozen=True)
class RunInfo:
    """Origin of a run: what was simulated, with what."""

    scenario_name: str
    scenario: str
    """The scenario at the start as YAML."""
    digest: str
    """Digest of the scenario and of the models."""
    sleeper_spacing: float
    """m; sleepers stand at its multiples."""
    versions: Mapping[str, str] = field(default_factory=versions)

    def to_metadata(self) -> dict[str, str]:
        """Record of text by name, as bags hold it."""
        plain = {item.name: str(getattr(self, item.name)) for item in fields(self) if item.name != "versions"}
        return plain | {f"version.{name}": number for name, number in self.versions.items()}

    @classmethod
    def from_metadata(cls, record: Mapping[str, str]) -> RunInfo:
        """RunInfo from its record; raises KeyError or ValueError if the record is not one."""
        return cls(
            scenario_name=record["scenario_name"],
            scenario=record["scenario"],
            digest=record["digest"],
            sleeper_spacing=float(record["sleeper_spacing"]),
            versions={
                name.removeprefix("version."): number for name, number in record.items() if name.startswith("version.")
            },
        )
