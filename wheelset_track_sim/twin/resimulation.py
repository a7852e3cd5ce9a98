"""A recorded run simulated again, revision by revision at their steps, beside what was recorded."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..bags import Bag
from ..bags.losses import Loss
from ..bags.run_info import versions
from ..errors import RecordingError
from ..live.origin import model_digests
from ..live.run_writer import RunWriter
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..samples.summary import Summary, combine, summarise
from ..scenario import WHEELS
from ..simulation.simulator import Simulator
from ..simulation.speed import Stretch
from ..wheelset.reduced import COMPONENTS
from .differences import Difference, Differences
from .recorded_run import Change, Recorded, recorded
from .what_if import with_settings

CHUNK = 5556
"""Steps at a time where nothing is compared."""
AGREEMENT = 1e-3
"""Share of the static load, and of the largest stress at the start, that is taken for agreement."""


@dataclass(frozen=True, eq=False)
class Again:
    """A run simulated again, over the samples that were recorded."""

    path: Path
    samples: int
    settings: tuple[str, ...]
    """What was set that was not recorded, ``key=value``."""
    inputs: Recorded
    moved: tuple[tuple[int, int, int], ...]
    """Changes that came into force at another step than recorded: revision, recorded step, step."""
    force: Difference | None
    """Of the contact forces, N; None if they are the same, bit by bit."""
    stress: Difference | None
    """Of the stress components, Pa."""
    before: Summary
    """Of the recorded samples."""
    after: Summary
    """Of the simulated ones, at the same steps."""
    origin: dict[str, tuple[str, str]]
    """Versions and models that differ: what the bag says, what is here."""
    duration: float
    """Of the recorded samples, s."""
    unknown: tuple[int, ...]
    """Revisions that the run had and the bag does not hold."""
    lost: tuple[Loss, ...]
    """What of the bag is damaged or missing; the rest is compared."""

    @property
    def identical(self) -> bool:
        """Whether all forces and stresses are the same, bit by bit."""
        return self.force is None and self.stress is None and not self.moved


def simulate_again(
    path: str | Path, settings: Sequence[str] = (), out: Path | None = None, progress: Progress | None = None
) -> Again:
    """Simulate the run of a bag again from what went in, and compare; with ``settings``, what would have been.

    ``out`` is a bag to write of the new run, over the steps that were recorded. A damaged bag is compared as far as it
    can be read. Memory does not grow with the run.
    Raises RecordingError if the bag cannot be read or does not say what went in, InputError for a setting that cannot
    be made.
    """
    lost: list[Loss] = []
    bag = Bag(Path(path), lost.append)
    inputs = recorded(bag)
    scenarios = with_settings([change.scenario for change in inputs.changes], settings)
    changes = [change._replace(scenario=new) for change, new in zip(inputs.changes, scenarios, strict=True)]
    kept = [_surfaces(old) == _surfaces(new) for old, new in zip(inputs.changes, changes, strict=True)]
    player = _Player(changes, kept, inputs.start, progress)
    comparison: _Comparison | None = None
    with ExitStack() as stack:
        writer: RunWriter | None = None
        for block in bag.blocks():
            if block.first_step < player.simulator.next_step:
                continue  # before all that the bag knows of its run
            for missing in player.up_to(block.first_step):
                if writer is not None:
                    writer.push(missing, summarise(missing))
            if comparison is None:
                comparison = _Comparison(block, player.simulator)
                if out is not None:
                    writer = stack.enter_context(RunWriter(out, player.simulator, start_ns=bag.start_ns))
            done = 0
            while done < len(block):
                simulated = player.advance(len(block) - done)
                part = comparison.push(block, done, simulated)
                if writer is not None:
                    writer.push(simulated, part)
                done += len(simulated)
        if writer is not None:
            writer.finish()
    if comparison is None:
        raise RecordingError(
            f"{bag.path} does not say what its samples were simulated from: record it with its state topic"
        )
    return Again(
        path=bag.path,
        samples=comparison.before.samples,
        settings=tuple(settings),
        inputs=inputs,
        moved=tuple(player.moved),
        force=comparison.force.found,
        stress=comparison.stress.found,
        before=comparison.before,
        after=comparison.after,
        origin=_other(bag.info.versions, versions()) | _other(bag.info.models, model_digests(player.simulator)),
        duration=comparison.duration,
        unknown=tuple(sorted(comparison.revisions.difference(change.revision for change in changes))),
        lost=tuple(lost),
    )


class _Player:
    """A simulator that is told each change in time.

    Changes come at their steps; from one surface that was not recorded, or to one, as soon as it is out of the patch.
    """

    def __init__(
        self, changes: Sequence[Change], kept: Sequence[bool], start: Stretch | None, progress: Progress | None
    ) -> None:
        self.moved: list[tuple[int, int, int]] = []
        exactly = [before and after for before, after in pairwise(kept)]
        self._left = deque(zip(changes[1:], exactly, strict=True))
        self._progress = progress
        self.simulator = Simulator(changes[0].scenario, progress, start=start)

    def advance(self, steps: int) -> SampleBlock:
        while self._left and self._left[0][0].step < self.simulator.next_step + steps:
            change, exactly = self._left.popleft()
            found = self.simulator.apply(change.scenario, self._progress, not_before=change.step, exactly=exactly)
            if found.step != change.step:
                self.moved.append((change.revision, change.step, found.step))
        return self.simulator.advance(steps)

    def up_to(self, step: int) -> Iterator[SampleBlock]:
        start = self.simulator.next_step
        while (left := step - self.simulator.next_step) > 0:
            yield self.advance(min(left, CHUNK))
            if self._progress:
                self._progress("simulate what comes before", (self.simulator.next_step - start) / (step - start))


class _Comparison:
    def __init__(self, first: SampleBlock, simulator: Simulator) -> None:
        nodes = simulator.scenario.output.stress_nodes
        self._rows = [(first.nodes.index(node), nodes.index(node)) for node in first.nodes if node in nodes]
        names = tuple(f"{first.nodes[row]} {component}" for row, _ in self._rows for component in COMPONENTS)
        self.force = Differences(WHEELS, AGREEMENT * simulator.scenario.wheel_load)
        self.stress = Differences(names, AGREEMENT * float(np.abs(first.stresses).max(initial=0.0)))
        self.duration = 0.0
        self.revisions: set[int] = set()
        self._before: Summary | None = None
        self._after: Summary | None = None

    @property
    def before(self) -> Summary:
        assert self._before is not None
        return self._before

    @property
    def after(self) -> Summary:
        assert self._after is not None
        return self._after

    def push(self, block: SampleBlock, done: int, simulated: SampleBlock) -> Summary:
        """Compare the samples of a recorded block behind the first ``done``; returns the summary of the simulated."""
        part = slice(done, done + len(simulated))
        self.force.push(block, done, block.forces[part], simulated.forces)
        ours, theirs = ([pair[which] for pair in self._rows] for which in (0, 1))
        if ours:
            shape = len(simulated), -1
            self.stress.push(
                block, done, block.stresses[part][:, ours].reshape(shape), simulated.stresses[:, theirs].reshape(shape)
            )
        if done == 0:
            self._before = _added(self._before, summarise(block))
            self.duration += len(block) * block.step_period
            self.revisions.add(block.revision)
        summary = summarise(simulated)
        self._after = _added(self._after, summary)
        return summary


def _surfaces(change: Change) -> tuple[object, ...]:
    """What the contact patch meets."""
    return change.scenario.irregularities, change.scenario.line_length


def _added(total: Summary | None, part: Summary) -> Summary:
    return part if total is None else combine([total, part])


def _other(there: Mapping[str, str], here: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    """What a bag says that is otherwise here."""
    return {name: (text, here.get(name, "none")) for name, text in there.items() if here.get(name) != text}
