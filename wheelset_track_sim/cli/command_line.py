"""The command line ``wheelset-track-sim``: exit status 0, 1 failed, 2 bad input (one line on standard error)."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

from ..errors import InputError
from ..inputs import shipped
from ..runtime.memory import keep_freed_memory
from ..runtime.output_files import require_folder
from ..version import __version__
from .ending import FAILED, complain, status_of
from .spectrum import add_arguments, run_spectrum
from .warned import printed_warnings

if TYPE_CHECKING:
    from ..bags.settings import RecordSettings
    from ..samples.impacts import ImpactSettings
    from ..twin.measured import Matching, Reading

PROGRAM = "wheelset-track-sim"
NO_PARAMETERS = ("command", "ros_arguments", "warnings")
"""Options of ``replay`` that are no parameters of its node."""
OLD_RESIMULATE = "--simulate-again"
"""Option that made ``replay`` simulate a bag again."""
EXAMPLES = "examples:"
USES = {
    "list": ["", "scenarios", "track --json"],
    "init": ["scenario flat_fresh", "scenario damage_wheel_1 mine.yaml", "wheelset x40 my_wheelset.yaml"],
    "run": [
        "damage_wheel_1",
        "flat_fresh --set 'speed=120 km/h' --set 'irregularities.0.length=40 mm'",
        "mine.yaml --duration 2 --out run.mcap",
        "mine.yaml --out run.csv",
    ],
    "show": ["mixed", "mine.yaml --out mine.pdf --overwrite"],
    "study": ["load_cases", "depth --dynamics paper --workers 2", "mine.yaml --out results/mine"],
    "report": ["run.mcap", "run.mcap --measured wayside.csv --out page.html"],
    "resimulate": ["run.mcap", "run.mcap --set 'wheel_1.damage.h=1 mm'"],
    "recover": ["damaged.mcap", "damaged.mcap --out whole.mcap"],
    "info": ["run.mcap", "run.mcap --json"],
    "compare": ["run.mcap wayside.csv", "run.mcap wayside.csv --unit kN --offset 'wheel_1=10 t'"],
    "stress": ["wayside.csv --wheelset trailer", "wayside.csv --speed 25 --nodes A1,B1 --out stress.csv"],
    "spectrum": [
        "run.mcap --signal wheel_1",
        "run.mcap --signal axle_box_acceleration/wheel_1 --third-octave",
        "run.mcap --signal A1_yy --orders --start 1 --json",
    ],
    "cache": ["", "--clear", "--clear kernels"],
    "demo": ["", "--out demo"],
    "get": ["", "speed wheel_1.damage.h", "--node /train/w1 axle_load"],
    "set": ["'speed=120 km/h'", "wheel_1.damage.a=0.02 'wheel_1.damage.h=1 mm'"],
    "call": [
        "pause",
        "set_speed speed=30 acceleration=1",
        "set_tread_damage 'damage=[{wheel: 1, a: 0.02, b: 0.016, h: 0.001}]'",
    ],
    "echo": ["summary", "state --count 1 --full", "contact_forces --json"],
    "replay": ["run.mcap --rate 2 --loop", "run.mcap --ros-args -r __node:=replay"],
}
"""Arguments of each command in its examples."""


class _Help(argparse.HelpFormatter):
    """Wraps descriptions, and keeps the lines of examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if not text.startswith(EXAMPLES):
            return super()._fill_text(text, width, indent)
        return "\n".join(indent + line for line in text.splitlines())


class _Parser(argparse.ArgumentParser):
    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=_Help, **options)

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message}: see {self.prog} --help")


_Commands: TypeAlias = "argparse._SubParsersAction[_Parser]"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    keep_freed_memory()
    # A node that is told to end before it has anything to close ends in order; a topic has no end of its own.
    proof = OLD_RESIMULATE in given
    interrupted = 0 if given[:1] in (["node"], ["replay"], ["echo"]) and not proof else FAILED
    return status_of(partial(_run_command, given), PROGRAM, interrupted)


def _run_command(given: list[str]) -> int:
    with printed_warnings(PROGRAM) as warnings:
        given = _renamed(given)
        if given[:1] == ["node"]:  # its arguments are those of every ROS node
            return _node(given[1:])
        own, of_ros = _split(given) if given[:1] == ["replay"] else (given, [])
        parser = _parser()
        if "_ARGCOMPLETE" in os.environ:  # a shell asks how the line can go on
            import_module("argcomplete").autocomplete(parser)
        options = parser.parse_args(own, argparse.Namespace(ros_arguments=of_ros, warnings=warnings))
        if getattr(options, "out", None) is not None:
            require_folder(options.out)
        command: Callable[[argparse.Namespace], int] = options.command
        return command(options)


def _renamed(given: list[str]) -> list[str]:
    """Arguments with the old name of a command replaced by the new one, which is reported."""
    if given[:1] != ["replay"] or OLD_RESIMULATE not in given:
        return given
    complain(PROGRAM, f"replay {OLD_RESIMULATE} is the old name of resimulate: use {PROGRAM} resimulate BAG", 0)
    return ["resimulate", *(each for each in given[1:] if each != OLD_RESIMULATE)]


def _split(given: Sequence[str]) -> tuple[list[str], list[str]]:
    """Our arguments, and those of ROS, which stand between ``--ros-args`` and ``--`` or the end."""
    ours: list[str] = []
    of_ros: list[str] = []
    inside = False
    for argument in given:
        inside = inside or argument == "--ros-args"
        (of_ros if inside else ours).append(argument)
        inside = inside and argument != "--"
    return ours, of_ros


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog=PROGRAM, description="Wheel-rail impact loads and axle stresses of damaged wheels.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)
    _add_list(commands)
    _add_init(commands)
    _add_run(commands)
    _add_show(commands)
    _add_study(commands)
    commands.add_parser("node", help="the ROS 2 node, with the arguments of every ROS node", add_help=False)
    _add_report(commands)
    _add_replay(commands)
    _add_get(commands)
    _add_set(commands)
    _add_call(commands)
    _add_echo(commands)
    _add_resimulate(commands)
    _add_recover(commands)
    _add_info(commands)
    _add_compare(commands)
    _add_stress(commands)
    _add_spectrum(commands)
    _add_cache(commands)
    _add_demo(commands)
    return parser


def _command(commands: _Commands, name: str, what: str, details: str = "") -> _Parser:
    description = f"{what[0].upper()}{what[1:]}. {details}".strip()
    return commands.add_parser(name, help=what, description=description, epilog=_examples(name))


def _examples(name: str) -> str:
    """Examples of a command, a line each."""
    return "\n".join([EXAMPLES, *(f"  {PROGRAM} {name} {line}".rstrip() for line in USES[name])])


def _takes_bag(command: _Parser, and_then: str = "") -> None:
    command.add_argument("bag", type=Path, metavar="BAG", help=f"an .mcap file or a bag folder{and_then}")


def _takes_changes(command: _Parser, what: str = "change a key, such as 'speed=100 km/h'") -> None:
    keys = "docs/scenarios.md lists the keys; numbers are in SI or have a unit"
    command.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=f"{what} ({keys})")


def _takes_threshold(command: _Parser, where: str = "") -> None:
    what = f"contact force that makes an impact{where} (default: 200e3)"
    command.add_argument("--threshold", type=float, metavar="N", help=what)


def _takes_measured(command: _Parser) -> None:
    command.add_argument(
        "--unit", action="append", default=[], metavar="UNIT", help="of forces, stresses or time, instead of the file's"
    )
    command.add_argument(
        "--sign", choices=("compression", "tension"), default="compression", help="what a positive force in the file is"
    )
    command.add_argument(
        "--offset",
        action="append",
        default=[],
        metavar="[WHEEL=]FORCE",
        help="add a force, such as 98.1kN or wheel_1=98.1kN, where a signal has no static load",
    )
    command.add_argument(
        "--column", action="append", default=[], metavar="WHEEL=NAME", help="column that holds wheel_1 or wheel_2"
    )


def _takes_place(command: _Parser) -> None:
    command.add_argument(
        "--lag", type=float, metavar="S", help="zero of the measurement in the simulation, about, s or m"
    )
    command.add_argument(
        "--origin", metavar="TIME", help="time stamp in the file at which the simulation begins, about: s, or ISO 8601"
    )


def _matching(options: argparse.Namespace) -> Matching:
    from ..inputs.table_rows import seconds_of
    from ..twin.measured import Matching

    given = {"lag": options.lag, "threshold": options.threshold}
    if options.origin is not None:
        given["origin"] = float(seconds_of(options.origin, "--origin"))
    return Matching(**{name: value for name, value in given.items() if value is not None})


def _reading(options: argparse.Namespace) -> Reading:
    from ..inputs.amounts import amount
    from ..twin.measured import Reading
    from ..twin.measured.measurement import WHEELS

    offsets: dict[str, float] = {}
    for text in options.offset:
        wheel, equals, force = text.rpartition("=")
        value = amount(force, "N", "--offset")
        offsets |= {wheel.strip(): value} if equals else dict.fromkeys(WHEELS, value)
    columns = {}
    for text in options.column:
        wheel, equals, name = text.partition("=")
        if not equals:
            raise InputError(f"--column {text!r} is not of the form wheel_1=NAME: give that of a column of the file")
        columns[wheel.strip()] = name.strip()
    return Reading(options.unit, options.sign, offsets, columns)


def _takes_json(command: _Parser, instead_of: str = "a table") -> None:
    command.add_argument("--json", action="store_true", help=f"print one JSON object instead of {instead_of}")


def _may_overwrite(command: _Parser) -> None:
    command.add_argument("--overwrite", action="store_true", help="replace files that exist already")


def _add_list(commands: _Commands) -> None:
    listing = _command(commands, "list", "what comes with the package, a line each")
    _takes_kind(listing, nargs="?", default=None)
    _takes_json(listing, "tables")
    listing.set_defaults(command=_list)


def _takes_shipped(command: _Parser, name: str, further: str = "") -> None:
    kind = shipped.kind_of(name)
    what = f"a file, or the name of a shipped one (see list {kind}){further}"
    named = command.add_argument(name, metavar=name.upper(), help=what)
    _completed(named, lambda prefix, **_: [*shipped.names(kind), *map(str, Path().glob(f"{prefix}*"))])


def _completed(argument: argparse.Action, completer: Callable[..., list[str]]) -> None:
    """Let shells complete an argument."""
    argument.completer = completer  # type: ignore[attr-defined]


def _takes_kind(command: _Parser, **options: Any) -> None:
    kinds = [shipped.singular(kind) for kind in shipped.kinds()]
    kind = command.add_argument("kind", metavar="KIND", help=f"one of {', '.join(kinds)}", **options)
    _completed(kind, lambda **_: kinds)


def _list(options: argparse.Namespace) -> int:
    from .listing import listed

    return listed(options.kind, json=options.json)


def _add_init(commands: _Commands) -> None:
    init = _command(commands, "init", "copy a shipped scenario, wheelset, track, vehicle or study to a file to edit")
    _takes_kind(init)
    name = init.add_argument("name", metavar="NAME", help="name of a shipped one: see list KIND")
    _completed(name, lambda parsed_args, **_: shipped.names(shipped.kind_of(parsed_args.kind)))
    init.add_argument("file", type=Path, nargs="?", metavar="FILE", help="the copy (default: NAME.yaml in this folder)")
    _may_overwrite(init)
    init.set_defaults(command=_init)


def _init(options: argparse.Namespace) -> int:
    from .init import init

    if options.file is not None:
        require_folder(options.file)
    return init(options.kind, options.name, options.file, PROGRAM, overwrite=options.overwrite)


def _add_run(commands: _Commands) -> None:
    run = _command(commands, "run", "simulate without ROS, as fast as possible")
    _takes_shipped(run, "scenario")
    _takes_changes(run)
    run.add_argument("--dynamics", help="causal (which streams) or paper (Green's functions as printed)")
    run.add_argument("--duration", type=float, metavar="S", help="simulated time (default: one turn of the wheel)")
    run.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="keep the run: a bag (FILE.mcap, or a folder without suffix), or a table (.csv, .parquet, .xlsx, .nc)",
    )
    run.add_argument("--split-size", type=int, metavar="BYTES", help="size at which the bag goes on in another file")
    run.add_argument("--split-duration", type=float, metavar="S", help="time of the run after which it does")
    run.add_argument("--max-total-size", type=int, metavar="BYTES", help="above it the oldest files are removed")
    run.add_argument(
        "--snapshots", type=float, metavar="S", help="record what is around impacts only, each from S before it"
    )
    _takes_threshold(run, " in the bag")
    _takes_json(run)
    run.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    from .run import run

    changes = [*options.set, *([f"dynamics={options.dynamics}"] if options.dynamics else [])]
    settings, impacts = _recorded(options)
    return run(
        options.scenario,
        changes,
        options.duration,
        options.out,
        json=options.json,
        settings=settings,
        impacts=impacts,
        warnings=options.warnings,
    )


def _recorded(options: argparse.Namespace) -> tuple[RecordSettings | None, ImpactSettings | None]:
    """How a run is recorded; InputError names the option."""
    from ..bags.settings import CONTINUOUS, SNAPSHOT, RecordSettings
    from ..samples.impacts import ImpactSettings

    named = {
        "max_size": "split_size",
        "max_duration": "split_duration",
        "max_total_size": "max_total_size",
        "snapshot_duration": "snapshots",
    }
    given = {name: value for name, option in named.items() if (value := getattr(options, option)) is not None}
    if options.out is None:
        for option in [*(named[name] for name in given), *(["threshold"] if options.threshold is not None else [])]:
            raise InputError(f"--{option.replace('_', '-')} is of a bag: give --out, too")
        return None, None
    try:
        settings = RecordSettings(CONTINUOUS if options.snapshots is None else SNAPSHOT, **given)
    except InputError as refusal:
        name, _, rest = str(refusal).partition(" ")
        raise InputError(f"--{named[name].replace('_', '-')} {rest}") from None
    return settings, None if options.threshold is None else ImpactSettings(options.threshold)


def _add_show(commands: _Commands) -> None:
    show = _command(commands, "show", "a picture of a scenario: treads, rails, profiles, supports, wheelset")
    _takes_shipped(show, "scenario")
    _takes_changes(show)
    show.add_argument("--out", type=Path, metavar="FILE", help="the picture: .png, .svg or .pdf (default: NAME.png)")
    _may_overwrite(show)
    show.set_defaults(command=_show)


def _show(options: argparse.Namespace) -> int:
    from .show import show

    return show(options.scenario, options.set, options.out, overwrite=options.overwrite)


def _add_study(commands: _Commands) -> None:
    study = _command(commands, "study", "a parameter study: runs, figures, tables, summary")
    _takes_shipped(study, "study", ", or all of these")
    study.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the results (default: results/STUDY-DYNAMICS)"
    )
    _takes_changes(study, "change a key in all runs")
    study.add_argument("--dynamics", help="causal or paper")
    study.add_argument("--workers", type=int, metavar="N", help="processes on this machine (default: one a core)")
    study.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786, does the runs"
    )
    study.add_argument("--parquet", action="store_true", help="write tables as Parquet, too (extra analysis)")
    study.set_defaults(command=_study)


def _study(options: argparse.Namespace) -> int:
    from ..studies.conduct import Resources
    from .study import study

    changes = [*options.set, *([f"dynamics={options.dynamics}"] if options.dynamics else [])]
    resources = Resources(options.workers, options.scheduler)
    return study(options.study, changes, options.out, resources, parquet=options.parquet)


def _add_report(commands: _Commands) -> None:
    report = _command(commands, "report", "a page and a table of a bag")
    _takes_bag(report)
    report.add_argument("--out", type=Path, metavar="FILE.html", help="the page (default: beside the bag)")
    report.add_argument(
        "--picture", type=Path, metavar="FILE", help="the picture: .png, .svg or .pdf (default: .png beside the page)"
    )
    _takes_threshold(report)
    report.add_argument("--measured", type=Path, metavar="FILE", help="text file or bag to show beside the run")
    _takes_place(report)
    _takes_measured(report)
    _may_overwrite(report)
    report.set_defaults(command=_report)


def _report(options: argparse.Namespace) -> int:
    from ..samples.impacts import ImpactSettings
    from .report import report

    settings = None if options.threshold is None else ImpactSettings(options.threshold)
    return report(
        options.bag,
        options.out,
        settings,
        options.measured,
        _matching(options),
        _reading(options),
        picture=options.picture,
        overwrite=options.overwrite,
    )


def _add_replay(commands: _Commands) -> None:
    replay = commands.add_parser(
        "replay",
        help="play a bag on the topics on which it was recorded",
        usage="%(prog)s [OPTION ...] BAG [--ros-args -p NAME:=VALUE -r FROM:=TO ...]",
        description="Play a bag on the topics on which it was recorded, as a ROS 2 node. Each option is a parameter. "
        f"To simulate its run again, use {PROGRAM} resimulate; replay {OLD_RESIMULATE} is the old name of that.",
        epilog=_examples("replay"),
    )
    replay.add_argument("bag", type=Path, nargs="?", metavar="BAG", help="an .mcap file or a bag folder")
    replay.add_argument("--rate", type=float, metavar="R", help="times as fast (default: 1; 0: as fast as possible)")
    replay.add_argument("--loop", action="store_true", default=None, help="begin again at the end")
    replay.add_argument("--start-offset", type=float, metavar="S", help="begin that long after the first message")
    replay.add_argument("--duration", type=float, metavar="S", help="end after that time in the bag")
    replay.add_argument("--stamps", metavar="original|now", help="stamps as recorded (default), or current ones")
    replay.add_argument("--publish-clock", action="store_true", default=None, help="publish the time on /clock")
    replay.add_argument("--prefix", metavar="NAME", help="put topics below this name, ~ is the node's own")
    replay.add_argument("--start-paused", action="store_true", default=None, help="wait for the service resume")
    replay.set_defaults(command=_replay)


def _replay(options: argparse.Namespace) -> int:
    from .nodes import replay

    parameters = {name: value for name, value in vars(options).items() if name not in NO_PARAMETERS}
    return replay(ros_arguments=options.ros_arguments, **parameters)


def _of_node(command: _Parser) -> None:
    command.add_argument("--node", default="wheelset_track_sim", metavar="NAME", help="of the node, with its namespace")
    command.add_argument(
        "--timeout", type=float, default=10.0, metavar="S", help="longest time to wait for the node (default: 10)"
    )


def _add_get(commands: _Commands) -> None:
    get = _command(commands, "get", "parameters of a running node, where there is no ros2")
    get.add_argument("parameters", nargs="*", metavar="NAME", help="names (default: all)")
    _of_node(get)
    _takes_json(get, "YAML")
    get.set_defaults(command=_get)


def _get(options: argparse.Namespace) -> int:
    from .nodes import get

    return get(options.node, options.parameters, options.timeout, json=options.json)


def _add_set(commands: _Commands) -> None:
    setting = _command(commands, "set", "set parameters of a running node, all or none")
    setting.add_argument("changes", nargs="+", metavar="NAME=VALUE", help="in SI, or with a unit: 'speed=100 km/h'")
    _of_node(setting)
    setting.set_defaults(command=_set)


def _set(options: argparse.Namespace) -> int:
    from .nodes import set_parameters

    return set_parameters(options.node, options.changes, options.timeout)


def _add_call(commands: _Commands) -> None:
    call = _command(commands, "call", "call a service of a running node", "The exit status is 1 if it has no success.")
    call.add_argument("service", metavar="SERVICE", help="such as pause or set_speed: docs/interface.md lists them")
    call.add_argument("fields", nargs="*", metavar="FIELD=VALUE", help="fields of the request in SI, as YAML")
    _of_node(call)
    _takes_json(call, "YAML")
    call.set_defaults(command=_call)


def _call(options: argparse.Namespace) -> int:
    from .nodes import call

    return call(options.node, options.service, options.fields, options.timeout, json=options.json)


def _add_echo(commands: _Commands) -> None:
    echo = _command(commands, "echo", "messages of a topic of a running node, until an interrupt")
    echo.add_argument("topic", metavar="TOPIC", help="such as summary or state: docs/interface.md lists them")
    echo.add_argument("--count", type=int, metavar="N", help="end after N messages")
    echo.add_argument("--full", action="store_true", help="print long lists of numbers whole")
    _of_node(echo)
    _takes_json(echo, "YAML")
    echo.set_defaults(command=_echo)


def _echo(options: argparse.Namespace) -> int:
    from .nodes import echo

    if options.count is not None and options.count < 1:
        raise InputError(f"--count {options.count} is out of range: give 1 or more")
    return echo(options.node, options.topic, options.count, options.timeout, json=options.json, full=options.full)


def _add_resimulate(commands: _Commands) -> None:
    resimulate = _command(
        commands,
        "resimulate",
        "simulate the run of a bag again, with each change at its step, and compare it with the recording",
        "Without --set, every force and stress is the same to the last bit on the software and processor that recorded "
        "it. The exit status is 1 if numbers differ, and no setting, version, processor, model or unknown input is a "
        "reason.",
    )
    _takes_bag(resimulate)
    _takes_changes(resimulate, "set a key throughout the run, such as wheel_1.damage.h=0.001 or track.spacing=0.65")
    resimulate.add_argument("--out", type=Path, metavar="BAG", help="record the new run: FILE.mcap, or a bag folder")
    resimulate.add_argument(
        "--most-steps", type=int, metavar="N", help="steps without samples to simulate, as before the bag (1e8)"
    )
    _takes_json(resimulate)
    resimulate.set_defaults(command=_resimulate)


def _resimulate(options: argparse.Namespace) -> int:
    from .resimulate import run_resimulate

    return run_resimulate(options.bag, options.set, options.out, options.most_steps, json=options.json)


def _add_recover(commands: _Commands) -> None:
    recover = _command(commands, "recover", "make a whole bag of what can be read of a damaged one")
    _takes_bag(recover, "; it stays as it is")
    recover.add_argument("--out", type=Path, metavar="NEW", help="the new bag (default: BAG_recovered beside it)")
    recover.set_defaults(command=_recover)


def _recover(options: argparse.Namespace) -> int:
    from .recover import run_recover

    return run_recover(options.bag, options.out)


def _add_info(commands: _Commands) -> None:
    info = _command(commands, "info", "what is in a bag: steps, revisions, peaks, gaps, files")
    _takes_bag(info)
    _takes_json(info, "tables")
    info.set_defaults(command=_info)


def _info(options: argparse.Namespace) -> int:
    from .info import info

    return info(options.bag, json=options.json)


def _add_compare(commands: _Commands) -> None:
    compare = _command(commands, "compare", "a bag beside measured wheel forces or axle stresses")
    _takes_bag(compare)
    compare.add_argument("measured", type=Path, metavar="FILE", help="a text file or a bag")
    _takes_place(compare)
    _takes_measured(compare)
    _takes_threshold(compare)
    _takes_json(compare, "tables")
    compare.set_defaults(command=_compare)


def _compare(options: argparse.Namespace) -> int:
    from .compare import compared

    return compared(
        options.bag,
        options.measured,
        _matching(options),
        _reading(options),
        json=options.json,
        warnings=options.warnings,
    )


def _add_stress(commands: _Commands) -> None:
    stress = _command(commands, "stress", "axle stresses from wheel forces alone")
    stress.add_argument("forces", type=Path, metavar="FORCES", help="text file: both forces over time or position")
    _takes_measured(stress)
    names = ", ".join(shipped.names("wheelsets"))
    stress.add_argument("--wheelset", default="x40", help=f"a file, or one of {names} (default: x40)")
    stress.add_argument("--nodes", metavar="A1,B1", help="stress nodes (default: all of the wheelset)")
    stress.add_argument("--speed", type=float, metavar="V", help="m/s, for forces over the position and for bags")
    stress.add_argument("--own-weight", action="store_true", help="add the stress of the wheelset's own weight")
    stress.add_argument("--out", type=Path, metavar="FILE", help="write stresses as .csv, or all as .mcap")
    _takes_json(stress)
    stress.set_defaults(command=_stress)


def _add_spectrum(commands: _Commands) -> None:
    spectrum = _command(commands, "spectrum", "frequencies, bands or orders of a signal in a bag")
    _takes_bag(spectrum)
    add_arguments(spectrum)
    _takes_json(spectrum)
    spectrum.set_defaults(command=run_spectrum)


def _stress(options: argparse.Namespace) -> int:
    from .stress import stress

    nodes = [name.strip() for name in options.nodes.split(",")] if options.nodes else None
    return stress(
        options.forces,
        options.wheelset,
        nodes,
        options.speed,
        options.out,
        _reading(options),
        own_weight=options.own_weight,
        json=options.json,
        warnings=options.warnings,
    )


def _add_cache(commands: _Commands) -> None:
    cache = _command(commands, "cache", "models and compiled functions on disk: where, how many, how large, last use")
    cache.add_argument(
        "--clear",
        nargs="?",
        const="all",
        metavar="KIND",
        help="remove one kind, or all: models are built again when needed",
    )
    _takes_json(cache)
    cache.set_defaults(command=_cache)


def _cache(options: argparse.Namespace) -> int:
    from .cache import cache

    return cache(options.clear, json=options.json)


def _add_demo(commands: _Commands) -> None:
    demo = _command(commands, "demo", "stream, record and report the paper's Section 5.1 through the ROS 2 node")
    demo.add_argument("--out", type=Path, default=Path("demo"), metavar="DIR", help="folder of bags and pictures")
    demo.set_defaults(command=_demo)


def _demo(options: argparse.Namespace) -> int:
    from .demo import demo

    return demo(options.out)


def _node(arguments: list[str]) -> int:
    from .nodes import node

    return node(arguments)


if __name__ == "__main__":
    sys.exit(main())
