"""One status line a subject, as ``diagnostic_msgs/DiagnosticStatus`` has it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..live.recorder import RecordingFigures
from ..verdict.limit_set import Level
from ..verdict.verdicts import Verdict, worst
from .limits import Limits


@dataclass(frozen=True)
class Status:
    """The state of one subject, such as ``wheel_1`` or ``stress A1``."""

    name: str
    level: Level
    message: str
    """One line for people: kN, MPa, ms."""
    values: tuple[tuple[str, str], ...] = ()
    """Names with their units, such as ``peak_force_N``, and values."""


@dataclass(frozen=True)
class WheelFigures:
    """What is known of a wheel."""

    peak_force: float
    """Largest force since the last report, and at least of the last turn, N."""
    turn_peak_force: float
    """Largest force of the last complete turn, N; NaN before the first."""
    static_force: float
    """At rest, N."""
    contact_loss: float
    """Time without contact since the last report, s."""
    impacts: int
    """Since the start."""
    threshold: float
    """Force that makes an impact, N."""


@dataclass(frozen=True)
class NodeFigures:
    """What is known of a stress node."""

    amplitude: float
    """Largest amplitude of the bending stress of a point of the turning axle since the last report, and at least of the
    last turn, Pa."""
    turn_amplitude: float
    """Of the last complete turn, Pa; NaN before the first."""
    mean: float
    """Axial stress of press fits and given stresses, which does not change as the axle turns, Pa."""
    peak: float
    """Largest principal stress since the last report, and at least of the last turn, Pa."""


@dataclass(frozen=True)
class PaceFigures:
    """How time is kept."""

    real_time_factor: float
    """Simulated over elapsed time of late; NaN if it is not known yet."""
    wanted: float
    """Real-time factor that is wanted; 0 is as fast as possible."""
    lag: float
    """Largest time behind the schedule since the last report, s."""


def wheel_level(peak_force: float, threshold: float, limits: Limits) -> Level:
    """Level of the largest contact force of a wheel."""
    return _level(peak_force, threshold, limits.force_error)


def stress_level(amplitude: float, limits: Limits) -> Level:
    """Level of the amplitude of the bending stress at a node."""
    return _level(amplitude, limits.stress_warn, limits.stress_error)


def lag_level(lag: float, limits: Limits) -> Level:
    """Level of the time behind the schedule."""
    return _level(lag, limits.lag_warn, limits.lag_error)


def pace_level(pace: PaceFigures, limits: Limits) -> Level:
    """Level of lag and of the real-time factor, the worse of them."""
    share = pace.real_time_factor / pace.wanted if pace.wanted > 0 else 1.0
    return max(lag_level(pace.lag, limits), _level(-share, -limits.pace_warn, -limits.pace_error))


def wheel_status(name: str, wheel: WheelFigures, limits: Limits) -> Status:
    """Status of a wheel."""
    level = wheel_level(wheel.peak_force, wheel.threshold, limits)
    told = f"peak {wheel.peak_force / 1e3:.0f} kN, {wheel.peak_force / wheel.static_force:.2f} times the static load"
    if level == Level.ERROR:
        told += f", above the limit of {limits.force_error / 1e3:.0f} kN"
    elif level == Level.WARN:
        told += f", above the impact threshold of {wheel.threshold / 1e3:.0f} kN"
    return Status(
        name,
        level,
        told,
        _values(
            peak_force_N=wheel.peak_force,
            turn_peak_force_N=wheel.turn_peak_force,
            static_force_N=wheel.static_force,
            dynamic_factor=wheel.peak_force / wheel.static_force,
            contact_loss_s=wheel.contact_loss,
            impacts=wheel.impacts,
            threshold_N=wheel.threshold,
            limit_N=limits.force_error,
        ),
    )


def stress_status(name: str, node: NodeFigures, limits: Limits) -> Status:
    """Status of a stress node."""
    level = stress_level(node.amplitude, limits)
    told = f"bending amplitude {node.amplitude / 1e6:.1f} MPa"
    if node.mean != 0.0:
        told += f" about a mean of {node.mean / 1e6:.1f} MPa"
    if level != Level.OK:
        limit = limits.stress_error if level == Level.ERROR else limits.stress_warn
        told += f", above the limit of {limit / 1e6:.0f} MPa"
    return Status(
        f"stress {name}",
        level,
        told,
        _values(
            bending_amplitude_Pa=node.amplitude,
            turn_bending_amplitude_Pa=node.turn_amplitude,
            mean_axial_Pa=node.mean,
            max_principal_Pa=node.peak,
            warn_limit_Pa=limits.stress_warn,
            error_limit_Pa=limits.stress_error,
        ),
    )


def verdict_status(found: Sequence[Verdict]) -> Status:
    """Status of what the run reached against a set of limits; the worst comparisons come first."""
    level = worst(found)
    told = "; ".join(each.text for each in found if each.level == level) if level else f"{len(found)} limits kept"
    values = tuple((f"{each.subject}.{each.quantity}", f"{each.level.word}: {each.text}") for each in found)
    return Status("verdict", level, told, values)


def pace_status(pace: PaceFigures, limits: Limits) -> Status:
    """Status of the pace."""
    factor = pace.real_time_factor
    told = "real-time factor not known yet" if math.isnan(factor) else f"{factor:.3g} times real time"
    if pace.wanted > 0:
        told += f", {pace.wanted:g} required, {pace.lag * 1e3:.0f} ms behind schedule"
    return Status(
        "pacing",
        pace_level(pace, limits),
        told,
        _values(real_time_factor=factor, wanted_real_time_factor=pace.wanted, lag_s=pace.lag),
    )


def recording_status(bag: RecordingFigures) -> Status:
    """Status of the bag."""
    level, told = Level.OK, f"to {bag.path}" if bag.path else "none"
    if bag.lost is not None:
        level, told = Level.ERROR, f"{told}: {bag.lost}" if bag.path else f"ended early: {bag.lost}"
    elif bag.refused is not None and not bag.path:
        level, told = Level.ERROR, f"not started: {bag.refused}"
    elif bag.path and bag.waiting > bag.buffer_size / 2:
        told += f": the disk is slow, {bag.waiting / 1e6:.0f} of {bag.buffer_size / 1e6:.0f} MB are buffered"
        level = Level.WARN
    return Status("recording", level, told, _values(waiting_bytes=bag.waiting, buffer_size_bytes=bag.buffer_size))


def _level(value: float, warn: float, error: float) -> Level:
    if value > error:
        return Level.ERROR
    return Level.WARN if value > warn else Level.OK


def _values(**values: float) -> tuple[tuple[str, str], ...]:
    return tuple((name, f"{value:.6g}") for name, value in values.items())
