"""The record of its run in each file of a bag: scenario, versions, digests, and all inputs up to there.

Each file begins with all inputs so far. So a part of a bag, or a recording that was started late, can be simulated
again from step 0 on.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import platform
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from typing import NamedTuple

from numba.core.registry import cpu_target
from threadpoolctl import threadpool_info

from ..runtime.cache import digest
from ..runtime.sources import whole_package
from ..version import __version__

METADATA_NAME = "wheelset_track_sim"
CHECKSUM = "crc32"
"""Key of the record's own checksum: MCAP has none for records outside of chunks until the file is closed."""
NAMED = {"versions": "version.", "models": "model."}
"""Fields that are mappings, with the prefix of their names in the record."""
MOST = 10_000
"""Changes that a file begins with at most, the latest."""
LARGEST = 1 << 28
"""Bytes of the changes of a file when they are read; fewer are written."""
_BEGIN = re.compile(r'\s*[\[,]\s*\[\s*([0-9]{1,1000})\s*,\s*([0-9]{1,1000})\s*,\s*"')
_END, _CLOSED, _NONE = (re.compile(each) for each in (r"\s*\]", r"\s*\]\s*", r"\s*\[\s*\]\s*"))
_OTHER = "one is not of two whole numbers and a text"


class Input(NamedTuple):
    """A change that has taken effect; revision 0 is the start."""

    revision: int
    step: int
    """First step with the change."""
    scenario: str
    """As YAML."""


def in_order(inputs: Iterable[Input]) -> tuple[Input, ...]:
    """Each revision once, with its first step: a state is repeated after a pause, and where a file begins."""
    first: dict[int, Input] = {}
    for found in sorted(inputs, key=lambda found: (found.revision, found.step)):
        first.setdefault(found.revision, found)
    return tuple(first.values())


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
    """Versions of everything that decides the last bit of a run's numbers: software, linear algebra, processor.

    ``sources`` is a digest of this package; the last eight digits of ``cpu`` are one of the instruction sets.
    """
    return dict(_versions())


def _checksum(record: Mapping[str, str]) -> str:
    """CRC-32 of all other texts of a record, as hexadecimal digits."""
    items = [item for name in sorted(record) if name != CHECKSUM for item in (name, record[name])]
    return f"{zlib.crc32(json.dumps(items).encode()):08x}"


@dataclass(frozen=True)
class RunInfo:
    """Origin of a run: scenario, software and models."""

    scenario_name: str
    scenario: str
    """The scenario in force where the bag begins, as YAML."""
    digest: str
    """Digest of that scenario and of the models."""
    sleeper_spacing: float
    """m; sleepers are at its multiples."""
    versions: Mapping[str, str] = field(default_factory=versions)
    models: Mapping[str, str] = field(default_factory=dict)
    """Digests of ``wheelset`` and ``track``, as their files describe them."""
    inputs: tuple[Input, ...] = ()
    """All changes of the run up to where the bag begins, from step 0 on."""

    def with_input(self, new: Input) -> RunInfo:
        """The same with a later input; the earliest are left out beyond ``MOST``."""
        if self.inputs and new.revision <= self.inputs[-1].revision:
            return self
        inputs = (*self.inputs, new)[-MOST:]
        while sum(len(each.scenario) for each in inputs) > LARGEST // 8:  # JSON takes up to six bytes a character
            inputs = inputs[1:]
        return dataclasses.replace(self, inputs=inputs)

    def to_metadata(self) -> dict[str, str]:
        """Record of text by name, as bags hold it."""
        record = {name: str(getattr(self, name)) for name in ("scenario_name", "scenario", "digest", "sleeper_spacing")}
        for name, prefix in NAMED.items():
            record |= {f"{prefix}{key}": text for key, text in getattr(self, name).items()}
        record |= {"inputs": encode_inputs(self.inputs)} if self.inputs else {}
        return record | {CHECKSUM: _checksum(record)}

    @classmethod
    def among(cls, name: str, record: Mapping[str, str]) -> RunInfo | None:
        """RunInfo from a metadata record of a bag; None if it is about something else, ValueError if it is damaged."""
        if name != METADATA_NAME and CHECKSUM not in record:
            return None
        try:
            return cls.from_metadata(record)
        except (LookupError, ValueError, OverflowError) as reason:
            raise ValueError(f"the description of its run cannot be read: {reason}") from reason

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
            inputs=decode_inputs(record["inputs"]) if "inputs" in record else (),
            **named,
        )


def encode_inputs(inputs: Iterable[Input]) -> str:
    """Inputs as text: JSON, compressed because the scenarios of a run are much alike, in base64."""
    return base64.b64encode(zlib.compress(json.dumps([*inputs]).encode())).decode()


def decode_inputs(text: str) -> tuple[Input, ...]:
    """Inputs from their text; raises ValueError if it is not one."""
    try:
        unpacker = zlib.decompressobj()
        found = unpacker.decompress(base64.b64decode(text, validate=True), LARGEST)
        if not unpacker.eof:
            raise ValueError(f"they have more than {LARGEST} bytes" if unpacker.unconsumed_tail else "they are cut off")  # noqa: TRY301
        return tuple(_inputs(found.decode()))
    except (ValueError, zlib.error) as reason:
        raise ValueError(f"inputs of the run cannot be read: {reason}") from reason


def _inputs(text: str) -> Iterator[Input]:
    """Inputs of a JSON text, one by one: a list of anything else could take a hundred times the memory of its text."""
    if _NONE.fullmatch(text):
        return
    decoder, place = json.JSONDecoder(), 0
    for _ in range(MOST):
        begin = _BEGIN.match(text, place)
        if begin is None:
            raise ValueError(_OTHER)
        scenario, place = decoder.raw_decode(text, begin.end() - 1)
        end = _END.match(text, place)
        if end is None:
            raise ValueError(_OTHER)
        place = end.end()
        yield _input(int(begin[1]), int(begin[2]), scenario)
        if _CLOSED.fullmatch(text, place):
            return
    raise ValueError(f"there are more than {MOST}")


def _input(revision: int, step: int, scenario: str) -> Input:
    if not (0 <= revision < 2**32 and 0 <= step < 2**64):
        raise ValueError("one has a revision or a step that cannot be")
    return Input(revision, step, scenario)
