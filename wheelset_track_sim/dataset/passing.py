"""Samples of one passage of a train: one run over the site, from which each wheelset branches off with its damage.

The run settles once, on rough treads, rails and supports that all wheelsets of the train have in common. It goes on
along the site. At its start step each sample branches off, its damage comes in where it is out of the contact patch,
and the signals are read. So a sample costs its own length, a stride of the run, and its share of settling.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..errors import ContactError, WheelsetTrackError, recorded_input
from ..irregularities import Irregularity, Joint, Roughness
from ..runtime import sources
from ..runtime.arrays import Real, Single
from ..samples.block import SampleBlock
from ..samples.decimation import REACH
from ..scenario import WHEELS, Scenario
from ..sensors.acquisition import Acquisition
from ..sensors.reading import SensorReader
from ..simulation.models import load_models
from ..simulation.simulator import Simulator
from ..track.supports import Scatter, SupportLine
from ..version import __version__
from ..wayside.detector import Detector
from ..wayside.history import wayside_reading
from .damage import irregularity
from .labels import LINE_BAYS, Label
from .spec import FORCES, DatasetSpec

BAYS = 48
"""Bays after which the supports of a site repeat."""
PEAKS = "peak_force"
"""Array of the largest contact forces at full rate, N; NaN for a sample that could not be simulated."""
AFTER = REACH + 2
"""Values after the last one that its low pass reads."""


@dataclass(frozen=True)
class ContactForces(Acquisition):
    """Contact forces, sampled as a sensor samples: without noise."""

    type: ClassVar[str] = FORCES
    topic: ClassVar[str] = FORCES
    unit: ClassVar[str] = "N"
    channels: ClassVar[tuple[str, ...]] = WHEELS

    range: float | None = None
    noise: float = 0.0
    drift: float = 0.0


@dataclass(frozen=True)
class Passing:
    """One passage of a train, as a worker is given it."""

    spec: DatasetSpec
    labels: tuple[Label, ...]


def program() -> str:
    """Digest of the program: its version and the sources of a sample."""
    return sources.program(__name__)


class Signals(NamedTuple):
    """An array of signals."""

    topic: str
    channels: tuple[str, ...]
    unit: str
    values: int
    """Of each channel of a sample."""
    rate: float
    """Hz"""


def signals_of(spec: DatasetSpec) -> list[Signals]:
    """What has an array each: contact forces, the sensors, and the detector if there is one."""
    found = [
        Signals(each.topic, each.channels, each.unit, spec.samples, spec.rate)
        for each in (ContactForces(rate=spec.rate), *spec.sensors)
    ]
    if spec.detector is not None:
        names = tuple(channel.name for channel in spec.detector.channels)
        units = ", ".join(dict.fromkeys(channel.unit for channel in spec.detector.channels))
        found.append(Signals(topic_of(spec.detector), names, units, spec.detector_samples, spec.detector.rate))
    return found


def topic_of(detector: Detector) -> str:
    """Name of the array of a detector."""
    return f"wayside/{detector.name}"


def simulate(passing: Passing, made_for: str) -> dict[str, Single]:
    """Arrays of the samples of a passage, (samples, channels, values) each, float32, and ``PEAKS`` (samples, 2).

    Raises WheelsetTrackError if this is another program than ``made_for``.
    """
    if made_for != program():
        raise WheelsetTrackError(
            f"this worker runs another version of the program ({__version__}): install the same version everywhere"
        )
    spec, first = passing.spec, passing.labels[0]
    arrays = {
        each.topic: np.full((len(passing.labels), len(each.channels), each.values), np.nan, np.float32)
        for each in signals_of(spec)
    }
    arrays[PEAKS] = np.full((len(passing.labels), 2), np.nan, np.float32)
    with recorded_input():
        scenario = site(spec, first)
        run = Simulator(scenario, models=load_models(scenario, tables="smooth"))
        run.settle()
        before = [np.zeros((0, 2))]
        for row, label in enumerate(passing.labels):
            while run.next_step < label.start_step:
                before.append(run.advance(label.start_step - run.next_step).forces)
            try:
                block = _passed(spec, run.branch(), label)
            except ContactError:
                continue
            for name, values in _read(spec, run, block, label).items():
                arrays[name][row] = values
            if spec.detector is not None:
                read = _detected(spec, spec.detector, np.concatenate([*before, block.forces]), label)
                arrays[topic_of(spec.detector)][row, :, : read.shape[1]] = read
            arrays[PEAKS][row] = block.forces.max(axis=0)
    return arrays


def site(spec: DatasetSpec, label: Label) -> Scenario:
    """The train on its site, without damage."""
    base = spec.base
    surfaces: list[Irregularity] = []
    for level, seed, pair in (
        (label.wheel_roughness, label.wheel_seed, ("wheel_1", "wheel_2")),
        (label.rail_roughness, label.rail_seed, ("rail_1", "rail_2")),
    ):
        if not math.isnan(level):
            surfaces += [Roughness(on, seed=2 * seed + side, level=level) for side, on in enumerate(pair)]  # type: ignore[arg-type]
    if not math.isnan(label.joint_position):
        place = {"position": label.joint_position, "dip_angle": label.joint_dip_angle, "gap": spec.joint.gap}
        surfaces += [Joint("rail_1", **place), Joint("rail_2", **place)]
    scatter = Scatter(pad_stiffness=label.pad_scatter, ballast_stiffness=label.ballast_scatter, seed=label.track_seed)
    scattered = label.pad_scatter > 0 or label.ballast_scatter > 0
    line = SupportLine(BAYS, scatter=scatter) if scattered else None
    return dataclasses.replace(
        base,
        speed=label.speed,
        axle_load=label.axle_load,
        track=dataclasses.replace(base.track, line=line),
        irregularities=(*base.irregularities, *surfaces),
        line_length=LINE_BAYS * base.track.spacing,
        settle_on="surfaces",
    )


def _passed(spec: DatasetSpec, run: Simulator, label: Label) -> SampleBlock:
    """Samples of a wheelset with its damage; raises ContactError if a contact problem has no solution."""
    damage = irregularity(label.damage, label.damaged_wheel, label.angle, label.sizes)
    if damage is not None:
        run.apply(dataclasses.replace(run.scenario, irregularities=(*run.scenario.irregularities, damage)))
        if run.changed_from != label.start_step:
            raise AssertionError(f"sample {label.sample}: its damage is in the contact patch where it comes in")
    steps = math.ceil((REACH + spec.samples + AFTER) / (spec.rate * run.step_period))
    block = run.advance(steps)
    if len(block) < steps:
        run.advance(1)  # from a step without solution, which raises
    return block


def _read(spec: DatasetSpec, run: Simulator, block: SampleBlock, label: Label) -> dict[str, Single]:
    """Signals (channels, values) by array, noise included."""
    block = dataclasses.replace(block, sensors={**block.sensors, FORCES: block.forces})
    found = {}
    for each in (ContactForces(rate=spec.rate), *spec.sensors):
        sensor: Any = dataclasses.replace(each, seed=label.noise_seed)
        reader = SensorReader(sensor, run.steps_per_revolution, run.models.tread_origin)
        chunks = [*reader.push(block, sensor), *reader.finish()]
        values = [np.concatenate([chunk.values[name] for chunk in chunks]) for name in each.channels]
        # The low pass of the first ones has steps on one side only.
        found[each.topic] = np.array(values)[:, REACH : REACH + spec.samples].astype(np.float32)
    return found


def detector_position(spec: DatasetSpec, detector: Detector, label: Label) -> float:
    """Where the detector stands: at the first bay from which on it reads nothing before the sample, m."""
    track, start = spec.base.track, label.start_step * spec.base.step_length
    before = detector.reach - detector.ends(track)[0]
    return track.spacing * math.ceil((start + REACH / spec.rate * label.speed + before) / track.spacing)


def _detected(spec: DatasetSpec, detector: Detector, forces: Real, label: Label) -> Single:
    """What the detector reads (channels, values), noise included, from the forces (steps, 2) since step 0, N."""
    base = spec.base
    reading = wayside_reading(
        detector,
        base.track,
        detector_position(spec, detector, label),
        forces,
        speed=label.speed,
        step_length=base.step_length,
    )
    values = reading.values.T
    noise = np.random.default_rng([label.noise_seed, 1]).standard_normal(values.shape)
    largest = np.abs(values).max(axis=1, keepdims=True)
    return np.asarray(values + spec.detector_noise * largest * noise, dtype=np.float32)
