"""``identify``: which damage explains a peak, a force history or a sensor's signal, and what follows."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.table import Table

from ..errors import InputError, warn
from ..fatigue.curve import load_curve
from ..identification.files import Given, read_observation, without_damage
from ..identification.kind_fits import TRACK_ERROR, identify
from ..identification.observation import Observation, PeakReading
from ..identification.prediction import Prediction, predict
from ..identification.results import EXPLAINS, LEAST, Identification, Interval
from ..inputs.amounts import in_unit
from ..report.figures import check_picture
from ..report.identified import draw_identification
from ..runtime.output_files import require_folder, require_new
from ..scenario import Scenario, load_scenario, override, scenario_from, take_in
from .console import print_object, terminal
from .progress import shown

SCENARIO = "undamaged"
SPEED, AXLE_LOAD = 100 / 3.6, 196200.0
"""Of a peak, if they are not given: m/s, N."""


@dataclass(frozen=True)
class Options:
    """What ``identify`` is asked for beside the data."""

    kinds: Sequence[str] = ()
    scenario: str | None = None
    changes: Sequence[str] = ()
    speeds: Sequence[float] = ()
    """Of each file of data, or one for all, m/s."""
    track_error: float = TRACK_ERROR
    out: Path | None = None
    picture: Path | None = None
    overwrite: bool = False
    predict_speeds: Sequence[float] = ()
    predict_loads: Sequence[float] = ()
    curve: str | None = None
    seed: int = 0


def run_identify(
    data: Sequence[Path],
    force: float | None,
    given: Given,
    options: Options,
    *,
    json: bool,
    warnings: Sequence[str] = (),
) -> int:
    """Identify and print; returns the exit status: 1 if nothing explains the data."""
    for path in (options.out, options.picture):
        if path is not None:
            require_folder(path)
            require_new([path], overwrite=options.overwrite)
    if options.picture is not None:
        check_picture(options.picture)
    if bool(data) == (force is not None):
        raise InputError("give either files of data, or a peak by --force")
    scenario, measured = data_of(data, force, given, options)
    curve = load_curve(options.curve) if options.curve else None
    with shown() as progress:
        found = identify(
            measured,
            scenario,
            options.kinds,
            wheel=given.wheel or "wheel_1",
            track_error=options.track_error,
            seed=options.seed,
            progress=progress,
        )
        explained = found.best.explains
        predicted: tuple[Prediction, ...] = ()
        if (options.predict_speeds or options.predict_loads or curve) and explained:
            predicted = predict(
                found,
                options.predict_speeds,
                options.predict_loads,
                curve=curve,
                seed=options.seed,
                progress=progress,
            )
    if not explained:
        warn(
            f"no kind explains the data: chi2/n of the best is {found.best.chi2_per_n:.2f}, above {EXPLAINS:g}, so "
            "nothing is predicted or written: give the right speed, load and noise, or data of one defect"
        )
    if options.picture is not None:
        draw_identification(found, options.picture)
    if options.out is not None and explained:
        options.out.write_text(found.damaged().to_yaml(), encoding="utf-8")
    if json:
        print_object(as_mapping(found, predicted) | {"warnings": [*warnings]})
    else:
        _print(found, predicted, options)
    return 0 if explained else 1


def data_of(
    paths: Sequence[Path], force: float | None, given: Given, options: Options
) -> tuple[Scenario, list[Observation] | PeakReading]:
    """Scenario on which damage is looked for, and the data; raises InputError for what is missing or cannot be used."""
    if force is not None:
        named = load_scenario(options.scenario or SCENARIO, options.changes)
        if len(options.speeds) > 1:
            raise InputError(f"--speed is given {len(options.speeds)} times for one peak: give it once")
        own = options.scenario is not None or bool(options.changes)
        speed: float = options.speeds[0] if options.speeds else named.speed if own else SPEED
        load = given.axle_load or (named.axle_load if own else AXLE_LOAD)
        further = {name: value for name, value in given.further().items() if name in ("noise", "gain_error")}
        return _undamaged(named), PeakReading(force, speed, load, **further)
    if len(options.speeds) not in (0, 1, len(paths)):
        raise InputError(
            f"--speed is given {len(options.speeds)} times for {len(paths)} files: give it once, or for each"
        )
    observations: list[Observation] = []
    recorded: Scenario | None = None
    for number, path in enumerate(paths):
        of_file = options.speeds[number if len(options.speeds) > 1 else 0] if options.speeds else None
        observation, scenario = read_observation(path, dataclasses.replace(given, speed=of_file))
        observations.append(observation)
        recorded = recorded or scenario
    if recorded is None or options.scenario is not None:
        return _undamaged(load_scenario(options.scenario or SCENARIO, options.changes)), observations
    mapping = dataclasses.replace(recorded, sensors=()).to_mapping()
    for change in options.changes:
        override(mapping, change)
    take_in(mapping)
    return _undamaged(scenario_from(mapping)), observations


def _undamaged(scenario: Scenario) -> Scenario:
    """The scenario without what is looked for, and without what has no place in a passage."""
    bare = without_damage(scenario)
    return dataclasses.replace(bare, settle_on="smooth", sensors=(), speed_plan=(), events=())


def as_mapping(found: Identification, predicted: Sequence[Prediction]) -> dict[str, Any]:
    """The object that ``identify --json`` prints."""
    return {
        "sources": [*found.sources],
        "wheel": found.wheel,
        "simulated_passages": found.simulated,
        "kinds": [
            {
                "kind": fit.kind,
                "probability": fit.probability,
                "chi2_per_n": fit.chi2_per_n,
                "explains": fit.explains,
                "parameters": {name: dataclasses.asdict(each) for name, each in fit.parameters.items()},
                "correlations": [[*pair, value] for pair, value in fit.correlations.items()],
            }
            for fit in found.kinds
        ],
        "predictions": [
            {
                "speed_m_s": each.speed,
                "axle_load_N": each.axle_load,
                "force_N": _plain(each.force),
                "nodes": {
                    name: {"max_principal_Pa": _plain(stress)}
                    | (
                        {
                            "damage_ratio_to_undamaged": _plain(each.damage_ratio[name]),
                            "damage_per_km": _plain(each.damage_per_km[name]),
                        }
                        if name in each.damage_ratio
                        else {}
                    )
                    for name, stress in each.nodes.items()
                },
            }
            for each in predicted
        ],
    }


def _plain(interval: Interval) -> dict[str, float]:
    return {"estimate": interval.estimate, "low": interval.low, "high": interval.high}


def _print(found: Identification, predicted: Sequence[Prediction], options: Options) -> None:
    console = terminal()
    console.print(_kinds(found))
    if predicted:
        console.print(_predictions(predicted))
    for what, path in (("picture ", options.picture), ("scenario", options.out)):
        if path is not None and path.exists():
            console.print(f"{what} {path}", highlight=False, soft_wrap=True)


def _kinds(found: Identification) -> Table:
    table = Table(
        title=f"{found.wheel}: damage that explains {', '.join(found.sources)}",
        title_justify="left",
        caption_justify="left",
        caption="median and 90 % interval; ?: the data cannot tell it\n"
        f"chi2/n up to {EXPLAINS:g}: the kind explains the data",
    )
    for heading in ("kind", "probability", "chi2/n", "", "estimate", "from", "to"):
        table.add_column(heading, justify="left" if heading in ("kind", "") else "right")
    for fit in found.kinds:
        mark = "" if fit.explains else " *"
        head = (fit.meaning + mark, f"{fit.probability:.1%}", f"{fit.chi2_per_n:.2f}")
        if fit.probability < LEAST or not fit.parameters:
            table.add_row(*head, "", "", "", "")
            continue
        for number, (name, each) in enumerate(fit.parameters.items()):
            told = "" if each.told else " ?"
            values = [_value(name, value) for value in (each.estimate, each.low, each.high)]
            label = name.removesuffix("_m").replace("_", " ") + told
            table.add_row(*(head if number == 0 else ("", "", "")), label, *values)
    if any(not fit.explains for fit in found.kinds):
        table.caption = f"{table.caption}\n* does not explain the data"
    return table


def _value(name: str, value: float) -> str:
    return f"{1e3 * value:.3g} mm" if name.endswith("_m") else f"{value:.3g}"


def _predictions(predicted: Sequence[Prediction]) -> Table:
    table = Table(title="What follows, wherever on the bay it strikes", title_justify="left")
    fatigue = any(each.damage_ratio for each in predicted)
    for heading in ("speed", "axle load", "", "estimate", "from", "to"):
        table.add_column(heading, justify="left" if not heading else "right")
    for each in predicted:
        head = in_unit(each.speed, "km/h", "m/s"), in_unit(each.axle_load, "t", "N")
        table.add_row(*head, "contact force", *_shown(each.force, 1e3, "kN"))
        for name, stress in each.nodes.items():
            table.add_row("", "", f"maximum principal stress {name}", *_shown(stress, 1e6, "MPa"))
        for name, ratio in each.damage_ratio.items():
            table.add_row("", "", f"fatigue damage {name}, ratio to undamaged", *_shown(ratio, 1.0, ""))
        for name, damage in each.damage_per_km.items():
            values = (f"{value:.2g}" for value in (damage.estimate, damage.low, damage.high))
            table.add_row("", "", f"fatigue damage {name} per km, elementary", *values)
    if fatigue:
        table.caption = "fatigue by the S-N curve that was given"
    return table


def _shown(interval: Interval, size: float, unit: str) -> list[str]:
    return [f"{value / size:.4g} {unit}".rstrip() for value in (interval.estimate, interval.low, interval.high)]
