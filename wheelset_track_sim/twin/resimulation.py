"""Simulate a recorded run again, with each change at its step, and compare it with the recording."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from time import monotonic

import numpy as np

from ..bags import Bag
from ..bags.losses import Loss
from ..bags.run_info import versions
from ..bags.sensor_records import sensor_parts
from ..errors import InputError, RecordingError
from ..live.run_messages import model_digests, record
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..samples.summary import Summary, combine, summarise
from ..scenario import WHEELS
from ..simulation.simulator import Simulator
from ..simulation.speed import Stretch
from ..wheelset.reduced import COMPONENTS
from .differences import Difference, RunDifferences
from .run_inputs import RecordedChange, RunInputs, run_inputs, with_settings
from .sensor_comparison import SensorComparison, SensorDifference

CHUNK = 5556
"""Steps at a time where nothing is compared."""
MOST_STEPS = 10**8
"""Steps in a row without samples that are simulated: an hour of the run."""
OTHER_DIGESTS = "0.1."
"""Versions whose digests of models have another form, so that they cannot be compared with those of today."""
AGREEMENT = 1e-3
"""Share of the static load, and of the largest stress at the start, that counts as agreement."""


@dataclass(frozen=True, eq=False)
class Resimulation:
    """A run simulated again, over the samples that were recorded; ``resimulate`` returns it."""

    path: Path
    samples: int
    """Steps that were compared."""
    nodes: tuple[str, ...]
    """Stress nodes that were compared."""
    left_out: tuple[str, ...]
    """What the bag holds and was not compared, besides what is lost."""
    settings: tuple[str, ...]
    """Settings other than recorded, ``key=value``."""
    inputs: RunInputs
    moved: tuple[tuple[int, int, int], ...]
    """Changes that came into force at another step than recorded: revision, recorded step, step."""
    force: Difference | None
    """Of the contact forces, N; None if they are the same, bit by bit."""
    stress: Difference | None
    """Of the stress components, Pa."""
    sensors: dict[str, SensorDifference | None]
    """By topic: of what the sensors gave; None if all samples are the same, bit by bit."""
    before: Summary
    """Of the recorded samples."""
    after: Summary
    """Of the simulated ones, at the same steps."""
    origin: dict[str, tuple[str, str]]
    """Versions and models that differ: as the bag names them, as they are here."""
    digests_differ: str
    """Version that recorded the bag, if its digests of models cannot be compared with those here; otherwise empty."""
    duration: float
    """Of the recorded samples, s."""
    unknown: tuple[int, ...]
    """Revisions of the run that the bag does not hold."""
    lost: tuple[Loss, ...]
    """Damaged or missing parts of the bag; the rest is compared."""

    @property
    def identical(self) -> bool:
        """Whether all forces, stresses and sensors that were compared are the same, bit by bit."""
        same = self.force is None and self.stress is None and not any(self.sensors.values())
        return same and not self.moved

    @property
    def unexplained(self) -> bool:
        """Whether the numbers differ although settings, software, processor and inputs are as recorded."""
        return not (self.identical or self.settings or self.origin or self.inputs.start or self.unknown)


def resimulate(
    path: str | Path,
    settings: Sequence[str] = (),
    out: Path | None = None,
    progress: Progress | None = None,
    most_steps: int = MOST_STEPS,
) -> Resimulation:
    """Simulate the run of a bag again from its inputs, and compare it with the recording.

    Memory does not grow with the length of the run.

    Parameters
    ----------
    path
        Bag, a file or a folder; a damaged one is compared as far as it can be read.
    settings
        ``key=value`` of a scenario, or of a parameter of the node, that hold throughout the new run.
    out
        Bag to write of the new run, over the steps that were recorded.
    progress
        Called with stage and fraction.
    most_steps
        Steps in a row without samples that are simulated at most, as before a recording that began late.

    Raises
    ------
    RecordingError
        The bag cannot be read or does not hold the inputs of its run.
    InputError
        A setting cannot be made, ``out`` exists or cannot be written, or the bag begins too late.

    Examples
    --------
    >>> resimulate("ten_seconds.mcap").identical
    True
    >>> shallower = resimulate("ten_seconds.mcap", ["irregularities.0.h=0.001"])
    >>> shallower.after.wheels[0].max_force < shallower.before.wheels[0].max_force
    True
    """
    lost: list[Loss] = []
    bag = Bag(Path(path), lost.append)
    inputs = run_inputs(bag)
    scenarios = with_settings([change.scenario for change in inputs.changes], settings)
    changes = [change._replace(scenario=new) for change, new in zip(inputs.changes, scenarios, strict=True)]
    kept = [_surfaces(old) == _surfaces(new) for old, new in zip(inputs.changes, changes, strict=True)]
    rerun = _Rerun(changes, kept, inputs.start, progress, most_steps)
    sensors = SensorComparison(rerun.simulator, sensor_parts(bag.reader.quiet))
    too_early = 0
    comparison: _Comparison | None = None
    with ExitStack() as stack:
        push: Callable[[SampleBlock, Summary], None] | None = None
        for block in bag.blocks():
            if block.first_step < rerun.simulator.next_step:
                too_early += len(block)  # before all inputs that the bag holds
                continue
            for missing in rerun.up_to(block.first_step):
                sensors.push(missing)
                if push is not None:
                    push(missing, summarise(missing))
            if comparison is None:
                comparison = _Comparison(block, rerun.simulator)
                if out is not None:
                    push = stack.enter_context(record(out, rerun.simulator, start_ns=bag.start_ns))
            done = 0
            while done < len(block):
                simulated = rerun.advance(len(block) - done)
                summary = comparison.push(block, done, simulated)
                sensors.push(simulated)
                if push is not None:
                    push(simulated, summary)
                done += len(simulated)
    sensors.finish()
    if comparison is None:
        raise RecordingError(f"{bag.path} does not describe the run of its samples: record it with its state topic")
    recorded_by = bag.info.versions.get("wheelset_track_sim", "")
    old = recorded_by if recorded_by.startswith(OTHER_DIGESTS) else ""
    return Resimulation(
        path=bag.path,
        samples=comparison.before.samples,
        nodes=comparison.nodes,
        left_out=comparison.left_out(too_early),
        settings=tuple(settings),
        inputs=inputs,
        moved=tuple(rerun.moved),
        force=comparison.force.found,
        stress=comparison.stress.found,
        sensors=sensors.found,
        before=comparison.before,
        after=comparison.after,
        origin=_other({"wheelset_track_sim": "unknown"} | dict(bag.info.versions), versions())
        | ({} if old else _other(bag.info.models, model_digests(rerun.simulator))),
        digests_differ=old,
        duration=comparison.duration,
        unknown=tuple(sorted(comparison.revisions.difference(change.revision for change in changes))),
        lost=tuple(lost),
    )


class _Rerun:
    """A simulator to which each recorded change is applied in time.

    A change takes effect at its recorded step. If the surfaces before or after it are not those of the recording,
    it waits from there on until it is out of the contact patch.
    """

    def __init__(
        self,
        changes: Sequence[RecordedChange],
        kept: Sequence[bool],
        start: Stretch | None,
        progress: Progress | None,
        most_steps: int,
    ) -> None:
        self._most = most_steps
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
        if step - start > self._most:
            raise self._too_long(step)
        while (left := step - self.simulator.next_step) > 0:
            yield self.advance(min(left, CHUNK))
            if self._progress:
                self._progress("simulate what comes before", (self.simulator.next_step - start) / (step - start))

    def _too_long(self, step: int) -> InputError:
        """Error for a step that is too far away, with the time that it takes to get there."""
        simulator = self.simulator
        begun, missing = simulator.next_step, step - simulator.next_step
        simulator.advance(CHUNK)  # compiles
        clock = monotonic()
        period = simulator.advance(CHUNK).step_period
        took = (monotonic() - clock) / CHUNK * missing
        return InputError(
            f"step {step} comes {missing} steps ({missing * period:.3g} s of the run) after step {begun}, and the bag "
            f"holds none between: simulating them takes about {took:.2g} s here, give --most-steps {missing} to do so"
        )


class _Comparison:
    def __init__(self, first: SampleBlock, simulator: Simulator) -> None:
        nodes = simulator.scenario.output.stress_nodes
        self.nodes = tuple(node for node in first.nodes if node in nodes)
        self._other_nodes = [node for node in first.nodes if node not in nodes]
        self._rows = [(first.nodes.index(node), nodes.index(node)) for node in first.nodes if node in nodes]
        names = tuple(f"{first.nodes[row]} {component}" for row, _ in self._rows for component in COMPONENTS)
        self.force = RunDifferences(WHEELS, AGREEMENT * simulator.scenario.wheel_load)
        self.stress = RunDifferences(names, AGREEMENT * float(np.abs(first.stresses).max(initial=0.0)))
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

    def left_out(self, too_early: int) -> tuple[str, ...]:
        """What of the recorded samples is not compared."""
        nodes = [f"stresses of {node}, which the scenario does not have" for node in self._other_nodes]
        steps = [f"{too_early} steps before the first inputs that the bag holds"] if too_early else []
        return (*nodes, *steps)

    def push(self, block: SampleBlock, done: int, simulated: SampleBlock) -> Summary:
        """Compare the samples of a recorded block after the first ``done``; returns the summary of the simulated."""
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


def _surfaces(change: RecordedChange) -> tuple[object, ...]:
    """Everything that shapes the surfaces in contact."""
    return change.scenario.irregularities, change.scenario.line_length


def _added(total: Summary | None, part: Summary) -> Summary:
    return part if total is None else combine([total, part])


def _other(there: Mapping[str, str], here: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    """Entries of a bag that differ here, with both values."""
    return {name: (text, here.get(name, "none")) for name, text in there.items() if here.get(name) != text}
