"""Ledger of fatigue damage: what each axle went through, run by run, in a file that survives a crash.

An entry is what one run, or a part of it, did to one axle: damage by stress node, angle from the axle's mark and
distance. A run has an identity, so that a ledger never counts the same steps of it twice: of two entries of the same
run, the one with all steps of the other replaces it. Merging ledgers is therefore idempotent, and their order does not
matter. Entries of several runs add up, as the damage of Miner does.

A file is written beside and moved into place, so that it is always whole. An entry that is not finished holds the state
of the count, from which it goes on with the same bits.
"""

from __future__ import annotations

import dataclasses
import fcntl
import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, RecordingError
from ..inputs.numpy_files import UNREADABLE
from ..inputs.schema import plain, read
from ..runtime.arrays import Real
from ..runtime.cache import digest
from .axle import AxleFatigue, NodeFatigue, equivalent_range
from .curve import Curve
from .rainflow_kernels import MEANS, RANGES

VERSION = 1
"""Of the file."""
SUFFIX = ".ledger"
LONGEST_NAME = 200
"""Characters of the name of an axle or a run."""
NEW, LONGER, KNOWN = "new", "longer", "known"
"""What an entry was to a ledger: none of its steps was there, all that were there and more, nothing new."""


@dataclass(frozen=True)
class Basis:
    """What damage depends on beside the run: entries with the same basis add up."""

    curve: Curve
    points: int
    """Around each node; the first is at the axle's mark."""
    gate: float
    """Pa."""

    def require(self, other: Basis, where: str) -> None:
        """Raise InputError if another basis is different; ``where`` names this one."""
        for name in ("curve", "points", "gate"):
            ours, theirs = getattr(self, name), getattr(other, name)
            if ours != theirs:
                told = [each.name if isinstance(each, Curve) else f"{each:g}" for each in (ours, theirs)]
                also = " with other constants" if told[0] == told[1] else ""
                raise InputError(
                    f"{where} has {name} {told[0]}, which damage by {name} {told[1]}{also} cannot be added to: "
                    f"give the same {name}, or another ledger"
                )


@dataclass(frozen=True, eq=False)
class LedgerEntry:
    """What steps of one run did to one axle."""

    axle: str
    """Identity of the axle."""
    run: str
    """Identity of the run: see ``run_identity``."""
    name: str
    """Of the scenario."""
    first_step: int
    steps: int
    step_length: float
    """m"""
    circumference: float
    """m"""
    nodes: tuple[str, ...]
    damage: Real
    """(nodes, K, rules)."""
    undamaged: Real
    """(nodes, rules)."""
    amplitude: Real
    """(nodes,) Pa."""
    mean: Real
    """(nodes,) Pa."""
    undamaged_amplitude: Real
    """(nodes,) Pa."""
    mark_distance: Real
    """(M,) distances since the first step, m."""
    mark_damage: Real
    """(M, nodes, K, rules) up to there."""
    cells: NDArray[np.int64]
    """(n,) cells of the range-mean matrices that are not empty, numbered through (nodes, K, ranges, means)."""
    half_cycles: NDArray[np.int64]
    """(n,) half cycles in these cells."""
    state: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """Of the count, if the run is not finished."""

    @classmethod
    def of(cls, fatigue: AxleFatigue, axle: str, run: str, name: str, *, finished: bool) -> LedgerEntry:
        """Entry of what was counted so far."""
        for what, text in (("axle", axle), ("run", run)):
            if not text.strip() or len(text) > LONGEST_NAME or not text.isprintable():
                raise InputError(f"{what} = {text!r} is no name: give 1 to {LONGEST_NAME} printable characters")
        assert fatigue.next_step is not None
        found = fatigue.nodes
        matrix = fatigue.spectrum.half_cycles.reshape(-1)
        cells = np.flatnonzero(matrix)
        distances, marked = fatigue.marks
        return cls(
            axle=axle,
            run=run,
            name=name,
            first_step=fatigue.next_step - fatigue.steps,
            steps=fatigue.steps,
            step_length=fatigue.wheel.step_length,
            circumference=fatigue.wheel.circumference,
            nodes=tuple(node.name for node in found),
            damage=fatigue.damage,
            undamaged=np.array([node.undamaged for node in found]),
            amplitude=np.array([node.amplitude for node in found]),
            mean=np.array([node.mean for node in found]),
            undamaged_amplitude=np.array([node.undamaged_amplitude for node in found]),
            mark_distance=distances,
            mark_damage=marked,
            cells=cells,
            half_cycles=matrix[cells],
            state={} if finished else fatigue.saved(),
        )

    @property
    def distance(self) -> float:
        """Of its steps, m."""
        return self.steps * self.step_length

    @property
    def end(self) -> int:
        """Step after the last one."""
        return self.first_step + self.steps

    def matrix(self, node: str, point: int) -> NDArray[np.int64]:
        """Half cycles of a point of a node by range and mean, (ranges, means)."""
        size = RANGES * MEANS
        start = (self.nodes.index(node) * self.damage.shape[1] + point) * size
        found = np.zeros(size, dtype=np.int64)
        within = (self.cells >= start) & (self.cells < start + size)
        found[self.cells[within] - start] = self.half_cycles[within]
        return found.reshape(RANGES, MEANS)


ARRAYS = tuple(each.name for each in dataclasses.fields(LedgerEntry) if each.type in ("Real", "NDArray[np.int64]"))
FACTS = tuple(each.name for each in dataclasses.fields(LedgerEntry) if each.name not in (*ARRAYS, "state"))


def run_identity(scenario: str, start_ns: int) -> str:
    """Identity of a run: a digest of its scenario at step 0, as YAML, and of the time stamp of that step, ns.

    A node's runs differ by their time. Runs without a clock are repeatable: the same scenario is the same run, and what
    it recorded has the same identity.
    """
    return digest([scenario, start_ns])


class Ledger:
    """Entries of axles and runs on one basis.

    Examples
    --------
    >>> ledger = Ledger(Basis(load_curve("assumed_body"), 36, GATE))
    >>> ledger.put(LedgerEntry.of(fatigue, "axle 7", "first run", "damage_wheel_1", finished=True))
    'new'
    """

    def __init__(self, basis: Basis) -> None:
        """Without entries."""
        self.basis = basis
        self._entries: list[LedgerEntry] = []

    @property
    def entries(self) -> tuple[LedgerEntry, ...]:
        """All entries, by axle, run and first step."""
        return tuple(sorted(self._entries, key=lambda each: (each.axle, each.run, each.first_step)))

    @property
    def axles(self) -> tuple[str, ...]:
        """Identities of the axles."""
        return tuple(sorted({each.axle for each in self._entries}))

    def put(self, entry: LedgerEntry) -> str:
        """Take in an entry: ``new``, ``longer`` than what it replaces, or ``known`` and ignored.

        Raises InputError if it overlaps with an entry of the same run and neither of them has all steps of the other.
        """
        same = [each for each in self._entries if (each.axle, each.run) == (entry.axle, entry.run)]
        overlap = [each for each in same if entry.first_step < each.end and each.first_step < entry.end]
        for each in overlap:
            covered = each.first_step <= entry.first_step and entry.end <= each.end
            finishes = (each.first_step, each.end) == (entry.first_step, entry.end) and each.state and not entry.state
            if covered and not finishes:
                return KNOWN
        for each in overlap:
            if entry.first_step > each.first_step or each.end > entry.end:
                raise InputError(
                    f"steps {entry.first_step} to {entry.end - 1} of run {entry.run} overlap with steps "
                    f"{each.first_step} to {each.end - 1}, which are in the ledger of axle {entry.axle} already: "
                    "give the whole run, or leave it out"
                )
        self._entries = [each for each in self._entries if each not in overlap] + [entry]
        return LONGER if overlap else NEW

    def merge(self, other: Ledger) -> list[str]:
        """Take in all entries of another ledger; what each was, in its order. Raises InputError."""
        self.basis.require(other.basis, "the ledger")
        return [self.put(entry) for entry in other.entries]

    def open_entry(self, axle: str, run: str) -> LedgerEntry | None:
        """The entry of a run whose count can go on, if there is one."""
        found = (each for each in self._entries if (each.axle, each.run) == (axle, run) and each.state)
        return next(found, None)

    def total(self, axle: str) -> tuple[NodeFatigue, ...]:
        """Damage of all runs of an axle by node.

        Amplitudes are the largest of all runs. The mean stress is that of the run with the largest one.
        """
        entries = [each for each in self.entries if each.axle == axle]
        names = dict.fromkeys(name for each in entries for name in each.nodes)
        return tuple(self._total_of(name, [each for each in entries if name in each.nodes]) for name in names)

    def _total_of(self, name: str, entries: list[LedgerEntry]) -> NodeFatigue:
        rows = [(each, each.nodes.index(name)) for each in entries]
        damage = np.sum([each.damage[row] for each, row in rows], axis=0)
        turns = sum(each.distance / each.circumference for each in entries)
        worst, row = max(rows, key=lambda pair: abs(float(pair[0].mean[pair[1]])))
        return NodeFatigue(
            name=name,
            distance=sum(each.distance for each in entries),
            amplitude=max(float(each.amplitude[row]) for each, row in rows),
            mean=float(worst.mean[row]),
            undamaged_amplitude=max(float(each.undamaged_amplitude[row]) for each, row in rows),
            angles=2 * np.pi * np.arange(self.basis.points) / self.basis.points,
            damage=damage,
            undamaged=np.sum([each.undamaged[row] for each, row in rows], axis=0),
            equivalent_range=equivalent_range(damage[:, 0].max() / turns, self.basis.curve),
        )

    def matrix(self, axle: str, node: str, point: int) -> NDArray[np.int64]:
        """Half cycles of a point by range and mean over all runs of an axle, (ranges, means)."""
        found = np.zeros((RANGES, MEANS), dtype=np.int64)
        for each in self._entries:
            if each.axle == axle and node in each.nodes:
                found += each.matrix(node, point)
        return found

    def to_bytes(self) -> bytes:
        """Content of a file: a numpy archive. The same ledger makes the same bytes."""
        arrays: dict[str, NDArray[Any]] = {}
        facts = []
        for number, entry in enumerate(self.entries):
            facts.append({name: getattr(entry, name) for name in FACTS} | {"state": [*entry.state]})
            arrays |= {f"{number}.{name}": getattr(entry, name) for name in ARRAYS}
            arrays |= {f"{number}.state.{name}": array for name, array in entry.state.items()}
        curve = plain(self.basis.curve)
        head = {"version": VERSION, "curve": curve, "points": self.basis.points, "gate": self.basis.gate}
        content = io.BytesIO()
        text = json.dumps(head | {"entries": facts}, sort_keys=True)
        np.savez_compressed(content, allow_pickle=False, head=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)
        return content.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes, name: str) -> Ledger:
        """Ledger of a file's content; raises RecordingError that begins with ``name``."""
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as stored:
                head = json.loads(stored["head"].tobytes().decode())
                if head["version"] != VERSION:
                    raise RecordingError(
                        f"{name} is a ledger of version {head['version']}: read it with the program that wrote it"
                    )
                ledger = cls(Basis(read(Curve, head["curve"], "curve"), int(head["points"]), float(head["gate"])))
                for number, facts in enumerate(head["entries"]):
                    state = {key: stored[f"{number}.state.{key}"] for key in facts.pop("state")}
                    arrays = {key: stored[f"{number}.{key}"] for key in ARRAYS}
                    entry = LedgerEntry(**{**facts, "nodes": tuple(facts["nodes"])}, **arrays, state=state)
                    _check(entry, ledger.basis)
                    ledger.put(entry)
        except UNREADABLE as reason:
            raise RecordingError(f"{name} is no ledger ({reason}): give a file that fatigue --ledger wrote") from None
        return ledger


def _check(entry: LedgerEntry, basis: Basis) -> None:
    """Raise ValueError if an entry does not fit together."""
    nodes, rules, marks = len(entry.nodes), len(basis.curve.rules), len(entry.mark_distance)
    shapes = {
        "damage": (nodes, basis.points, rules),
        "undamaged": (nodes, rules),
        "mark_damage": (marks, nodes, basis.points, rules),
        **dict.fromkeys(("amplitude", "mean", "undamaged_amplitude"), (nodes,)),
    }
    for name, shape in shapes.items():
        if getattr(entry, name).shape != shape or not np.isfinite(getattr(entry, name)).all():
            raise ValueError(f"{name} of run {entry.run} is not of shape {shape} and finite")
    cells = nodes * basis.points * RANGES * MEANS
    known = bool(((entry.cells >= 0) & (entry.cells < cells)).all())
    if entry.steps < 1 or entry.cells.shape != entry.half_cycles.shape or not known:
        raise ValueError(f"steps or cells of run {entry.run} are out of range")


def load_ledger(path: Path) -> Ledger:
    """Read a ledger; raises RecordingError if there is none that can be used."""
    try:
        content = path.read_bytes()
    except OSError as reason:
        raise RecordingError(f"{path} cannot be read ({reason.strerror}): give a ledger of fatigue --ledger") from None
    return Ledger.from_bytes(content, str(path))


@contextmanager
def changed_ledger(path: Path, basis: Basis) -> Iterator[Ledger]:
    """Ledger of a file, or a new one, which is written when the context ends without an exception.

    The file is locked meanwhile, so that several processes may write it. It is replaced as a whole: after a crash it is
    as before or as after the change. Raises InputError for another basis or a path that cannot be written.
    """
    try:
        with _locked(path):
            ledger = load_ledger(path) if path.exists() else Ledger(basis)
            ledger.basis.require(basis, str(path))
            yield ledger
            _replace(path, ledger.to_bytes())
    except OSError as reason:
        raise InputError(f"{path} cannot be written ({reason.strerror}): give another --ledger") from None


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """The system takes the lock away when the process ends, however it does."""
    with path.with_name(f".{path.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _replace(path: Path, content: bytes) -> None:
    """Write a file whole, and have it on the disk when this returns."""
    temporary = path.with_name(f".{path.name}.tmp")
    with temporary.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)
    folder = os.open(path.absolute().parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
