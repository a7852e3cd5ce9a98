"""All that the report needs of a run, from one pass through it: memory does not grow with its length."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..bags import Bag, Loss, RunInfo, State
from ..bags.irregularities_text import listed_irregularities
from ..bags.sensor_records import sensor_parts
from ..errors import InputError, recorded_input
from ..inputs.text_files import without_files
from ..inputs.yaml12 import parse
from ..samples.block import SampleBlock
from ..samples.impacts import Impact, ImpactDetector, ImpactSettings
from ..samples.spread import Spread, TurnSpread
from ..samples.summary import Summary, combine, summarise
from ..samples.turns import TurnWatch
from ..scenario import Scenario, scenario_from
from ..verdict.bending import BendingAmplitudes
from ..verdict.limit_set import LimitSet
from ..verdict.verdicts import Verdict, verdicts
from .envelope import Bins, Envelope
from .published import LoadCasePassage, published_passage
from .samples import Closeup, Closeups, SampleSeries, joined, samples_of
from .sensor_figures import SensorFigures, sensor_figures
from .spectrum import Spectrum, Welch

BEFORE, AFTER = 0.9, 1.8
"""Track of a close-up before and after a peak, m: about one turn of the wheel."""
AT_ONCE = 2**16
"""Steps of a gap that are passed at once."""
ROUNDING = 1e-6
"""Far below a step and far above the rounding of a position, m."""


@dataclass(frozen=True)
class Peak:
    """The largest contact force of a run."""

    wheel: int
    """0 or 1."""
    step: int
    time: float
    """s"""
    position: float
    """m"""
    force: float
    """N"""
    revision: int


@dataclass(frozen=True)
class InForce:
    """Conditions from a step of the run on; NaN and None are what the bag does not contain."""

    revision: int
    step: int
    """First step."""
    time: float
    """Of that step, s."""
    set_point: float
    """Speed that is approached, m/s."""
    speeds: tuple[float, float] | None
    """Smallest and largest speed of the samples, m/s; None if there are none."""
    axle_load: float
    """N"""
    irregularities: tuple[Mapping[str, Any], ...] | None
    """All of treads and rails, as in a scenario file."""


class _Driven(NamedTuple):
    """Samples of a revision."""

    step: int
    time: float
    slowest: float
    fastest: float


@dataclass(frozen=True, eq=False)
class Survey:
    """A run in bounded size."""

    path: Path
    info: RunInfo
    scenario: Scenario | None
    """At the start; None if the bag has none that this version can read."""
    rolling_radius: float
    """Of the wheels, m; NaN if unknown."""
    states: tuple[State, ...]
    start_ns: int
    """Time stamp of step 0, ns since the epoch."""
    nodes: tuple[str, ...]
    steps: int
    start: float
    """Simulated time of the first sample, s."""
    end: float
    """Simulated time after the last sample, s."""
    duration: float
    """Of all samples, s."""
    distance: float
    """Of all samples, m."""
    speeds: tuple[tuple[float, float], ...]
    """Speed, m/s, from a time on, s."""
    in_force: tuple[InForce, ...]
    """What was in force, revision by revision."""
    summary: Summary
    amplitudes: tuple[float, ...]
    """Bending amplitude at each node in the turn with the largest, Pa; NaN if unknown."""
    passage: LoadCasePassage | None
    peak: Peak
    bins: Bins
    closeups: tuple[Closeup, ...]
    """Around the largest forces, the largest first."""
    spectrum: Spectrum | None
    threshold: float
    """Force that makes an impact, N; NaN if impacts are not looked for, because the wheel is unknown."""
    impacts: tuple[Impact, ...]
    losses: tuple[Loss, ...] = ()
    """What of the bag is damaged or missing."""
    sensors: tuple[SensorFigures, ...] = ()
    turns: int = 0
    """Complete turns of the wheels."""
    by_turn: tuple[Spread, ...] = ()
    """Of the largest force of each wheel, N, and the largest principal stress of each node, Pa, in a turn."""
    """What each sensor gave."""
    limits: LimitSet | None = None
    """What the run is compared with."""

    @property
    def wheel_load(self) -> float:
        """Force of each wheel at rest, N; NaN if unknown, or if it changed during the run."""
        loads = self.axle_loads
        return loads[0] / 2 if loads and loads[0] == loads[1] else math.nan

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """The largest forces, damage lengths and bending amplitudes against the limits; empty without limits."""
        if self.limits is None:
            return ()
        forces = [wheel.max_force for wheel in self.summary.wheels]
        damage = [item for held in self.in_force for item in held.irregularities or ()]
        return verdicts(self.limits, forces, damage, dict(zip(self.nodes, self.amplitudes, strict=True)))

    @property
    def axle_loads(self) -> tuple[float, float] | None:
        """Smallest and largest axle load, N; None if one is unknown."""
        loads = [held.axle_load for held in self.in_force]
        return (min(loads), max(loads)) if loads and not any(map(math.isnan, loads)) else None

    def scenario_in_force(self, revision: int) -> Scenario | None:
        """Scenario of a revision; None if the bag has none that this version can read."""
        texts = (state.scenario for state in self.states if state.revision == revision)
        return _read(next(texts, self.info.scenario))


def survey(path: Path, settings: ImpactSettings | None = None, limits: LimitSet | None = None) -> Survey:
    """Survey of a bag, with impacts as the settings say; of what can be read of it, if it is damaged or has gaps.

    ``limits`` are what its verdicts compare with.

    Raises RecordingError in one line if the bag is missing or holds no run.
    """
    losses: list[Loss] = []
    bag = Bag(path, losses.append)
    found = survey_of(bag.events(), bag.info, bag.start_ns, bag.path, settings)
    sensors = sensor_figures(sensor_parts(bag.reader.quiet), found.peak.time)
    return dataclasses.replace(found, losses=tuple(losses), sensors=tuple(sensors), limits=limits)


def survey_of(
    events: Iterable[SampleBlock | State],
    info: RunInfo,
    start_ns: int,
    path: Path,
    settings: ImpactSettings | None = None,
) -> Survey:
    """Survey of blocks and states in their order."""
    collected: _Collected | None = None
    states: list[State] = []
    for event in events:
        if isinstance(event, State):
            states.append(event)
            continue
        collected = collected or _Collected(event, info, settings or ImpactSettings())
        loads = (state.axle_load / 2 for state in reversed(states) if state.revision == event.revision)
        collected.push(event, next(loads, collected.wheel_load))
    assert collected is not None
    return collected.survey(path, tuple(states), start_ns)


class _Collected:
    """What is kept while the blocks pass by."""

    def __init__(self, first: SampleBlock, info: RunInfo, settings: ImpactSettings) -> None:
        self._info, self._scenario = info, _read(info.scenario)
        self._first = self._last = first
        dx = first.speed * first.step_period
        before, after = round(BEFORE / dx), round(AFTER / dx)
        self._envelope = Envelope()
        self._closeups = Closeups(before, after, late=after)
        self._welch = Welch()
        self._total: Summary | None = None
        self._peak: Peak | None = None
        self._speeds: list[tuple[float, float]] = []
        self._driven: dict[int, _Driven] = {}
        self._steps, self._duration = 0, 0.0
        passage = published_passage(self._scenario, info.sleeper_spacing)
        self._passage = passage if passage and first.position <= passage[1] + ROUNDING else None
        self._passed: list[tuple[Summary, SampleSeries]] = []
        self._radius, self._threshold = self._scenario.wheelset.rolling_radius if self._scenario else math.nan, math.nan
        self._impacts: list[Impact] = []
        self._settings, self._detector = settings, self._new_detector(settings)
        self._bending = BendingAmplitudes.of(self._scenario, self._turn, first.nodes) if self._scenario else None
        self._watch = TurnWatch(self._turn) if self._scenario else None
        self._by_turn = TurnSpread()
        self.wheel_load = math.nan
        if self._detector and self._scenario:
            self.wheel_load = self._scenario.wheel_load
            self._threshold = settings.threshold

    def _new_detector(self, settings: ImpactSettings) -> ImpactDetector | None:
        """None if the wheel is unknown."""
        if self._scenario is None or math.isnan(self._radius):
            return None
        origin = round(self._scenario.reference_position / (self._first.speed * self._first.step_period))
        return ImpactDetector(self._turn, origin, settings)

    @property
    def _turn(self) -> int:
        """Steps of a turn of the wheels."""
        return round(2 * math.pi * self._radius / (self._first.speed * self._first.step_period))

    def push(self, block: SampleBlock, wheel_load: float) -> None:
        if self._total is not None:
            self._pass_gap(block)
        samples, part = samples_of(block), summarise(block)
        self._total = part if self._total is None else combine([self._total, part])
        self._envelope.push(samples)
        self._welch.push(block.speed, block.step_period, samples.values)
        self._closeups.push(samples)
        self._look_for_peak(block, samples)
        if self._bending:
            self._bending.push(block)
        if self._watch:
            for turn in self._watch.push(block, part):
                self._by_turn.push(turn)
        if self._detector:
            self._keep(self._detector.push(block, wheel_load))
        if not self._speeds or self._speeds[-1][1] != block.speed:
            self._speeds.append((block.time, block.speed))
        new = _Driven(block.first_step, block.time, block.speed, block.speed)
        start = self._driven.setdefault(block.revision, new)
        slowest, fastest = min(start.slowest, block.speed), max(start.fastest, block.speed)
        self._driven[block.revision] = start._replace(slowest=slowest, fastest=fastest)
        self._steps += len(block)
        self._duration += len(block) * block.step_period
        self._collect_passage(block, samples)
        self._last = block

    def _pass_gap(self, block: SampleBlock) -> None:
        """Leave steps blank that are missing before a block."""
        last = self._last
        step, time = last.first_step + len(last), last.time + len(last) * last.step_period
        missing = block.first_step - step
        if missing <= 0:
            return
        period, dx = (block.time - time) / missing, last.speed * last.step_period
        for start in range(0, missing, AT_ONCE):
            within = np.arange(start, min(start + AT_ONCE, missing), dtype=np.float64)
            nothing = np.full((len(within), block.forces.shape[1] + len(block.nodes)), math.nan)
            samples = SampleSeries(step + start, time + within * period, (step + within) * dx, nothing)
            self._envelope.push(samples)
            self._closeups.push(samples)
        self._welch.leave()
        if self._bending:
            self._bending.leave()
        if self._watch:
            self._watch = TurnWatch(self._turn)
        if self._detector:
            self._keep(self._detector.finish())
            self._detector = self._new_detector(self._settings)
        if self._passage and last.position + len(last) * dx < self._passage[2]:
            self._passage = None

    def _keep(self, impacts: list[Impact]) -> None:
        self._impacts += impacts
        for impact in impacts:
            self._closeups.peak(impact.step, impact.peak_force)

    def _look_for_peak(self, block: SampleBlock, samples: SampleSeries) -> None:
        row, wheel = divmod(int(block.forces.argmax()), block.forces.shape[1])
        force = float(block.forces[row, wheel])
        if self._peak is None or force > self._peak.force:
            step = block.first_step + row
            where = float(samples.time[row]), float(samples.position[row])
            self._peak = Peak(wheel, step, *where, force, block.revision)
            self._closeups.peak(step, force)

    def _collect_passage(self, block: SampleBlock, samples: SampleSeries) -> None:
        if self._passage is None:
            return
        _, first, last = self._passage
        if block.revision:
            self._passage = None
            return
        start, stop = np.searchsorted(samples.position, [first - ROUNDING, last - ROUNDING])
        if stop > start:
            cut = samples.between(samples.first_step + int(start), samples.first_step + int(stop))
            whole = dataclasses.replace(
                block,
                first_step=cut.first_step,
                time=float(cut.time[0]),
                position=float(cut.position[0]),
                forces=block.forces[start:stop],
                stresses=block.stresses[start:stop],
            )
            self._passed.append((summarise(whole), cut))

    def survey(self, path: Path, states: tuple[State, ...], start_ns: int) -> Survey:
        if self._detector:
            self._keep(self._detector.finish())
        assert self._total is not None
        assert self._peak is not None
        first, last = self._first, self._last
        dx = first.speed * first.step_period
        end = last.position + (len(last) - 1) * dx
        passage = None
        if self._passage and self._passed and end >= self._passage[2] - ROUNDING:
            summaries, samples = zip(*self._passed, strict=True)
            passage = LoadCasePassage(*self._passage, combine(summaries), joined(samples))
        return Survey(
            path=path,
            info=self._info,
            scenario=self._scenario,
            rolling_radius=self._radius,
            states=states,
            start_ns=start_ns,
            nodes=first.nodes,
            steps=self._steps,
            start=first.time,
            end=last.time + len(last) * last.step_period,
            duration=self._duration,
            distance=self._steps * dx,
            speeds=tuple(self._speeds),
            in_force=_in_force(self._driven, states, self._info),
            summary=self._total,
            turns=self._by_turn.turns,
            by_turn=self._by_turn.spreads,
            amplitudes=self._bending.largest if self._bending else (math.nan,) * len(first.nodes),
            passage=passage,
            peak=self._peak,
            bins=self._envelope.bins(),
            closeups=tuple(self._closeups.found()),
            spectrum=self._welch.spectrum(),
            threshold=self._threshold,
            impacts=tuple(sorted(self._impacts, key=lambda impact: impact.step)),
        )


def _in_force(driven: Mapping[int, _Driven], states: Iterable[State], info: RunInfo) -> tuple[InForce, ...]:
    """Revisions of a run in their order; those of samples whose state is not recorded are as the bag's inputs say."""
    told: dict[int, State] = {}
    for state in states:
        told.setdefault(state.revision, state)
    revisions = sorted({*driven, *told})
    texts = {found.revision: found.scenario for found in info.inputs} or {revisions[0]: info.scenario}
    found = []
    for revision in revisions:
        samples = driven.get(revision)
        speeds = (samples.slowest, samples.fastest) if samples else None
        if revision in told:
            now = told[revision]
            numbers = now.first_step, now.time, now.speed_set_point, speeds, now.axle_load
            found.append(InForce(revision, *numbers, now.irregularities))
        else:
            text = texts.get(revision, "")
            scenario, start = _read(text), driven[revision]
            set_point, load = (scenario.speed, scenario.axle_load) if scenario else (math.nan, math.nan)
            numbers = start.step, start.time, set_point, speeds, load
            found.append(InForce(revision, *numbers, listed_irregularities(text)))
    return tuple(found)


def _read(text: str) -> Scenario | None:
    try:
        with recorded_input(), without_files():
            return scenario_from(parse(text, "scenario of the bag", trusted=False))
    except InputError:
        return None
