"""One run of a study: what a worker is given, what it does, what it hands back."""

from __future__ import annotations

import dataclasses
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import WheelsetTrackError
from ..fatigue.axle import AxleFatigue, TurningWheel
from ..fatigue.curve import Curve
from ..fatigue.static_stress import static_stress
from ..irregularities import rail_heights, tread_heights
from ..irregularities.surface import RAILS
from ..runtime import sources
from ..runtime.arrays import Real
from ..runtime.cache import digest
from ..samples.block import SampleBlock
from ..samples.principal import maximum_principal
from ..samples.spread import Spread
from ..samples.summary import Summary, combine, summarise
from ..scenario import WHEELS, Scenario
from ..simulation.models import Models, load_models
from ..simulation.places import advanced, at_places, runs
from ..simulation.simulator import Simulator
from ..version import __version__
from ..wayside.watch import WaysideWatch
from .outputs import LARGEST, SMALLEST, nodes_of_fatigue, value_of, values_of_fatigue, wayside_values

INSTANTS = ("reference", "max_force")
"""Instants of a contact pressure: angle 0 of the treads meets the rail; the wheel's contact force is largest."""
PRESSURES = tuple(f"{wheel}.{instant}" for wheel in WHEELS for instant in INSTANTS)


@dataclass(frozen=True)
class Job:
    """What is simulated and what is kept of it."""

    scenario: Scenario
    before: float
    """Track from which results are kept, before the place where angle 0 of the treads meets the rail, m."""
    after: float
    """The same after that place, m."""
    outputs: tuple[str, ...]
    histories: tuple[str, ...] = ()
    pressures: tuple[str, ...] = ()
    curve: Curve | None = None
    """S-N curve of outputs of fatigue."""
    places: int = 1
    """Places of the bay at which the run is repeated; histories and pressures are those of the first."""

    @property
    def first_step(self) -> int:
        """First step that is kept."""
        return round((self.scenario.reference_position - self.before) / self.scenario.step_length)

    @property
    def samples(self) -> int:
        """Steps that are kept, both ends included."""
        return round((self.before + self.after) / self.scenario.step_length) + 1

    @property
    def effort(self) -> float:
        """Steps to simulate, roughly: the settling phase takes the same time at every speed."""
        return self.scenario.speed / self.scenario.step_length + self.first_step + self.samples

    @property
    def reads_wayside(self) -> bool:
        """Whether something is kept of what detectors beside the track read."""
        return any(name.startswith("wayside.") for name in self.outputs)

    def digest(self) -> str:
        """Digest of all that changes the result: scenario, what is kept, the program.

        The program includes kinds of irregularities of other packages. The scenario's name changes nothing.
        """
        scenario = dataclasses.replace(self.scenario, name="any")
        kept = [self.before, self.after, self.outputs, self.histories, self.pressures, self.curve, self.places]
        kinds = sorted({type(each).__module__ for each in scenario.all_irregularities})
        return digest([program(), *map(sources.program, kinds), scenario, kept])


@dataclass(frozen=True, eq=False)
class Result:
    """What is kept of a run."""

    values: dict[str, float]
    """Outputs by name, SI: of several places the median, with ``smallest`` and ``largest`` behind the name as well."""
    arrays: dict[str, Real]
    """Histories: ``position`` (n,) m along the track, ``forces`` (n, 2) N, ``principal`` (n, nodes) Pa,
    ``displacements`` (n, 2, 2) m, ``irregularity`` (n, 2) m. Pressures: ``wheel_1.reference.pressure`` (nx, ny) Pa with
    ``.x`` and ``.y`` in m and ``.at``: position in m, force in N, y of the rolling circle in m."""


def program() -> str:
    """Digest of the program: its version and the sources of a run."""
    return sources.program(__name__)


def evaluate(job: Job, made_for: str) -> Result:
    """Simulate a job and keep what it asks for; ``made_for`` is the program that the study runs on.

    Raises WheelsetTrackError if the scenario cannot be simulated, or if this is another program.
    """
    if made_for != program():
        raise WheelsetTrackError(
            f"this worker runs another version of the program ({__version__}): install the same version everywhere"
        )
    simulator = Simulator(job.scenario, models=models(job.scenario))
    simulator.require(job.first_step + job.samples)
    _kept.settled = {simulator.settling: simulator.settle(_kept.settled.get(simulator.settling))}
    scenario = job.scenario
    watch = WaysideWatch(scenario.wayside if job.reads_wayside else (), scenario.track, scenario.step_length)
    passed: dict[str, float] = {}

    def advance(steps: int) -> SampleBlock:
        block = simulator.advance(steps)
        for passage in watch.push(block):
            passed.update(wayside_values(passage))
        return block

    while simulator.next_step < job.first_step:
        advance(job.first_step - simulator.next_step)
    summaries: list[Summary] = []
    histories: dict[str, list[Real]] = {name: [] for name in job.histories}
    arrays: dict[str, Real] = {}
    end = job.first_step + job.samples
    fatigue = _fatigue(job, simulator)
    while simulator.next_step < end:  # a change of speed ends a block
        block = advance(end - simulator.next_step)
        summaries.append(summarise(block))
        if fatigue:
            fatigue.push(block)
        for name, parts in histories.items():
            parts.append(history(name, simulator, block))
        for name in job.pressures:
            arrays |= pressure(name, simulator, block, arrays.get(f"{name}.at"))
    summary = combine(summaries)
    others = passed | (values_of_fatigue(fatigue.nodes) if fatigue else {})
    values = {name: others[name] if name in others else value_of(summary, name) for name in job.outputs}
    if job.places > 1:
        values = _over_places(job, values, simulator.models)
    if histories:
        arrays |= {name: np.concatenate(parts) for name, parts in histories.items()}
        arrays["position"] = np.arange(job.first_step, end, dtype=np.float64) * job.scenario.step_length
    return Result(values, arrays)


def _fatigue(job: Job, simulator: Simulator) -> AxleFatigue | None:
    """What counts the cycles of a job, if an output is one of fatigue."""
    nodes = nodes_of_fatigue(job.outputs)
    if job.curve is None or not nodes:
        return None
    static = static_stress(job.scenario, simulator.models.reduced, nodes)
    return AxleFatigue(static, TurningWheel.of(job.scenario), job.curve)


def _over_places(job: Job, first: dict[str, float], common: Models) -> dict[str, float]:
    """Outputs over places of the bay, those of the ``first`` one being known."""
    found = [first]
    for simulator in runs(at_places(job.scenario, job.places)[1:], common):
        start = round((simulator.scenario.reference_position - job.before) / job.scenario.step_length)
        for _ in advanced(simulator, start):
            pass
        summary = combine([summarise(block) for block in advanced(simulator, job.samples)])
        found.append({name: value_of(summary, name) for name in job.outputs})
    values: dict[str, float] = {}
    for name in job.outputs:
        spread = Spread.of([each[name] for each in found])
        values |= {name: spread.median, name + SMALLEST: spread.low, name + LARGEST: spread.high}
    return values


def models(scenario: Scenario) -> Models:
    """Models of a scenario, kept for the thread's next run, which mostly differs in damage or speed alone.

    So is the settled state, from which the next run begins if it is under the same conditions: the bits are the same.

    Only the smooth tread has contact tables: a defect that passes once is solved faster than tabulated.
    """
    common = dataclasses.replace(scenario, **ANY).digest
    if getattr(_kept, "common", None) != common:
        _kept.models, _kept.common, _kept.settled = load_models(scenario, tables="smooth"), common, {}
    kept: Models = _kept.models
    return kept


ANY: dict[str, Any] = {
    "name": "any",
    "speed": 25.0,
    "acceleration": 1.0,
    "speed_plan": (),
    "events": (),
    "axle_load": 2e5,
    "irregularities": (),
    "line_length": None,
    "settle_on": "surfaces",
    "wayside": (),
}
"""Values for the keys on which models do not depend."""

_kept = threading.local()


def history(name: str, simulator: Simulator, block: SampleBlock) -> Real:
    """One history over the latest block, samples first."""
    if name == "forces":
        return block.forces
    if name == "principal":
        stress: Real = maximum_principal(block.stresses)
        return stress
    if name == "displacements":
        return simulator.displacements
    common, scenario = simulator.models, simulator.in_force
    steps, dx = block.first_step + np.arange(len(block)), common.step_length
    turn, line = common.steps_per_revolution, scenario.line_steps
    heights = np.empty((len(block), 2))
    for wheel, (on_wheel, on_rail) in enumerate(zip(WHEELS, RAILS, strict=True)):
        touch = np.array([common.geometry.touch(wheel)])
        of_tread = touch - common.geometry.rolling_circle(wheel)
        tread = tread_heights(scenario.irregularities, on_wheel, turn, dx, of_tread)
        rail = rail_heights(scenario.irregularities, on_rail, line, dx, touch)
        heights[:, wheel] = tread[(steps - common.tread_origin) % turn, 0] + rail.heights[rail.row[steps % line], 0]
    return heights


def pressure(name: str, simulator: Simulator, block: SampleBlock, found: Real | None) -> dict[str, Real]:
    """Contact pressure at one instant, if it is in the latest block.

    ``found`` is ``.at`` of the largest one in the blocks before, if there were any.
    """
    wheel_name, instant = name.split(".")
    wheel = WHEELS.index(wheel_name)
    if instant == "reference":
        row = simulator.models.tread_origin - block.first_step
        if not 0 <= row < len(block):
            return {}
    else:
        row = int(block.forces[:, wheel].argmax())
        if found is not None and block.forces[row, wheel] <= found[1]:
            return {}
    patch = simulator.contact_patch(wheel, row)
    position = block.position + row * simulator.in_force.step_length
    return {
        f"{name}.pressure": patch.pressure,
        f"{name}.x": patch.x,
        f"{name}.y": patch.y,
        f"{name}.at": np.array([position, patch.force, simulator.models.geometry.rolling_circle(wheel)]),
    }
