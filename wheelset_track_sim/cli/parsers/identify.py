"""Arguments of ``identify``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ...inputs import shipped
from ...inputs.amounts import amount
from .measured import reading_of, takes_measured
from .options import may_overwrite, takes_changes, takes_json
from .parser import Amount, Commands, command, completed

KINDS = ("flat", "worn_flat", "breakout", "none", "any")


class Amounts(argparse.Action):
    """Takes one amount each time that the option is given."""

    def __init__(self, *, unit: str, **options: Any) -> None:
        super().__init__(**options)
        self._unit = unit

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option_string: Any = None
    ) -> None:
        """Append the value; raises InputError for what is not an amount."""
        taken = [*getattr(namespace, self.dest), amount(values, self._unit, option_string or self.dest)]
        setattr(namespace, self.dest, taken)


def add(commands: Commands) -> None:
    """Add the command."""
    identify = command(
        commands,
        "identify",
        "find the tread damage that explains a peak force, a force history, or a signal of the wheelset",
        "Kinds of damage are compared, and sizes come with 90 % intervals. Status 1 means that nothing explains the "
        "data.",
        uses=[
            "--force '250 kN' --speed '100 km/h' --kind flat",
            "passage.csv --speed '93 km/h' --axle-load '22.5 t' --picture fit.png --out damage.yaml",
            "first.csv second.csv --speed '93 km/h' --speed '71 km/h' --axle-load '20 t' --predict '60 km/h'",
            "boxes.mcap --signal axle_box_acceleration --json",
        ],
    )
    identify.add_argument("data", nargs="*", type=Path, metavar="DATA", help="CSV files or bags, one of each passage")
    identify.add_argument("--force", action=Amount, unit="N", metavar="FORCE", help="a peak contact force alone")
    identify.add_argument(
        "--speed",
        action=Amounts,
        unit="m/s",
        default=[],
        metavar="SPEED",
        help="speed of the passage (default: that of a bag or scenario); repeat it for more files",
    )
    identify.add_argument(
        "--axle-load",
        action=Amount,
        unit="N",
        metavar="LOAD",
        help="load on both wheels together (default: as for --speed); CSV files need both",
    )
    identify.add_argument(
        "--kind",
        action="append",
        default=[],
        choices=KINDS,
        help="kind of damage to look for (default: any); repeat the option for more",
    )
    identify.add_argument(
        "--signal",
        metavar="NAME",
        help="force or axle_box_acceleration (default: force, or what the columns of a file hold)",
    )
    identify.add_argument("--wheel", choices=("wheel_1", "wheel_2"), help="damaged wheel (default: the larger peak)")
    identify.add_argument(
        "--noise",
        type=float,
        metavar="NUMBER",
        help="standard deviation of a sample, SI (default: 2e3 N, or 2 m/s^2)",
    )
    for name, what, default in (
        ("gain", "gain of the data", "3 %%"),
        ("speed", "speed", "0.5 %%"),
        ("track", "stiffness and damping of pads and ballast", "10 %%"),
        ("shape", "model beside that, of the size of its signal", "2 %% of a force, else 5 %%"),
    ):
        identify.add_argument(
            f"--{name}-error",
            action=Amount,
            unit="",
            metavar="SHARE",
            help=f"standard deviation of the {what} (default: {default})",
        )
    named = identify.add_argument(
        "--scenario", metavar="SCENARIO", help="wheelset and track (default: that of a bag, or undamaged)"
    )
    completed(named, lambda prefix, **_: [*shipped.names("scenarios"), *map(str, Path().glob(f"{prefix}*"))])
    takes_changes(identify)
    takes_measured(identify)
    identify.add_argument("--out", type=Path, metavar="FILE.yaml", help="write the damage as a scenario to run")
    identify.add_argument("--picture", type=Path, metavar="FILE", help="draw data, fit and band (.png, .svg, .pdf)")
    may_overwrite(identify)
    identify.add_argument(
        "--predict",
        action=Amounts,
        unit="m/s",
        default=[],
        metavar="SPEED",
        help="predict force and stress at this speed; repeat the option for more",
    )
    identify.add_argument(
        "--predict-load",
        action=Amounts,
        unit="N",
        default=[],
        metavar="LOAD",
        help="the same at this axle load; repeat the option for more",
    )
    identify.add_argument(
        "--curve", metavar="CURVE", help="also predict fatigue damage by this S-N curve (list woehler prints names)"
    )
    identify.add_argument("--seed", type=int, default=0, metavar="NUMBER", help="seed of the draws (default: 0)")
    takes_json(identify)
    identify.set_defaults(command=_identify)


def _identify(options: argparse.Namespace) -> int:
    from ...identification.files import Given
    from ..identify import Options, run_identify

    track = {} if options.track_error is None else {"track_error": options.track_error}
    given = Given(
        signal=options.signal,
        wheel=options.wheel,
        axle_load=options.axle_load,
        noise=options.noise,
        gain_error=options.gain_error,
        speed_error=options.speed_error,
        shape_error=options.shape_error,
        reading=reading_of(options),
    )
    return run_identify(
        options.data,
        options.force,
        given,
        Options(
            kinds=options.kind,
            scenario=options.scenario,
            changes=options.set,
            speeds=options.speed,
            out=options.out,
            picture=options.picture,
            overwrite=options.overwrite,
            predict_speeds=options.predict,
            predict_loads=options.predict_load,
            curve=options.curve,
            seed=options.seed,
            **track,
        ),
        json=options.json,
        warnings=options.warnings,
    )
