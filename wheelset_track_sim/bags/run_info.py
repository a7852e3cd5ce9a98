"""What a bag says about its run, beside the samples."""

from __future__ import annotations

import dataclasses
import json
import platform
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version

from numba.core.registry import cpu_target
from threadpoolctl import threadpool_info

from ..runtime.cache import digest
from ..runtime.sources import whole_package
from ..version import __version__
from .inputs import Input, decoded, encoded, with_input

METADATA_NAME = "wheelset_track_sim"
CHECKSUM = "crc32"
"""Key of the record's own checksum: MCAP has none for what stands outside of chunks until the file is closed."""
NAMED = {"versions": "version.", "models": "model."}
"""Fields that are mappings, with what stands before their names in the record."""


@cache
def _versions() -> dict[str, str]:
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba", "llvmlite")}
    algebra = sorted(
        {f"{item['internal_api']} {item['version']} {item.get('architecture', '')}".strip() for item in _blas()}
    )
    _, processor, features = cpu_target.target_context.codegen().magic_tuple()  # what numba compiles for
    return {
        "wheelset_track_sim": __version__,
        "sources": whole_package(),
        "python": platform.python_version(),
        **libraries,
        "blas": ", ".join(algebra),
        "cpu": f"{platform.machine()} {processor} {digest(features)[:8]}",
    }


def _blas() -> list[dict[str, str]]:
    return [item for item in threadpool_info() if item["user_api"] == "blas"]


def versions() -> dict[str, str]:
    """Versions of all that decides the numbers of a run to the last bit: software, linear algebra, processor.

    ``sources`` is a digest of this package, the processor's eight last digits one of its instruction sets.
    """
    return dict(_versions())


def _checksum(record: Mapping[str, str]) -> str:
    """CRC-32 of all other texts of a record, as hexadecimal digits."""
    told = [item for name in sorted(record) if name != CHECKSUM for item in (name, record[name])]
    return f"{zlib.crc32(json.dumps(told).encode()):08x}"


@dataclass(frozen=True)
class RunInfo:
    """Origin of a run: what was simulated, with what."""

    scenario_name: str
    scenario: str
    """The scenario in force where the bag begins, as YAML."""
    digest: str
    """Digest of that scenario and of the models."""
    sleeper_spacing: float
    """m; sleepers stand at its multiples."""
    versions: Mapping[str, str] = field(default_factory=versions)
    models: Mapping[str, str] = field(default_factory=dict)
    """Digests of ``wheelset`` and ``track``, as their files describe them."""
    inputs: tuple[Input, ...] = ()
    """What went into the run up to where the bag begins, from step 0 on."""

    def with_input(self, new: Input) -> RunInfo:
        """The same with one more input, unless it is there already."""
        return dataclasses.replace(self, inputs=with_input(self.inputs, new))

    def to_metadata(self) -> dict[str, str]:
        """Record of text by name, as bags hold it."""
        record = {name: str(getattr(self, name)) for name in ("scenario_name", "scenario", "digest", "sleeper_spacing")}
        for name, prefix in NAMED.items():
            record |= {f"{prefix}{key}": text for key, text in getattr(self, name).items()}
        record |= {"inputs": encoded(self.inputs)} if self.inputs else {}
        return record | {CHECKSUM: _checksum(record)}

    @classmethod
    def among(cls, name: str, record: Mapping[str, str]) -> RunInfo | None:
        """RunInfo from a metadata record of a bag; None if it is about something else, ValueError if it is damaged."""
        if name != METADATA_NAME and CHECKSUM not in record:
            return None
        try:
            return cls.from_metadata(record)
        except (LookupError, ValueError) as reason:
            raise ValueError(f"what it says about its run is lost: {reason}") from reason

    @classmethod
    def from_metadata(cls, record: Mapping[str, str]) -> RunInfo:
        """RunInfo from its record; raises KeyError or ValueError if the record is not one, or not as it was written."""
        if record.get(CHECKSUM, "") not in ("", _checksum(record)):
            raise ValueError("its checksum is wrong")
        named = {
            name: {key.removeprefix(prefix): text for key, text in record.items() if key.startswith(prefix)}
            for name, prefix in NAMED.items()
        }
        return cls(
            scenario_name=record["scenario_name"],
            scenario=record["scenario"],
            digest=record["digest"],
            sleeper_spacing=float(record["sleeper_spacing"]),
            inputs=decoded(record["inputs"]) if "inputs" in record else (),
            **named,
        )
