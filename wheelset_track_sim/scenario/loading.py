"""Scenarios from files and mappings, with ``dotted.key=value`` changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..contact.named_profiles import with_points
from ..errors import InputError
from ..inputs import shipped
from ..inputs.dotted import put
from ..inputs.schema import read
from ..inputs.shipped import MAX_DEPTH, load_yaml
from ..inputs.text_files import is_file
from ..inputs.yaml12 import parse
from .events import plain_brought
from .meaning import quantity_at
from .scenario import TRACK, WHEELSET, Scenario

MODELS = {"wheelset": WHEELSET, "track": TRACK, "vehicle": None}
"""Keys that name a model, with the model of a scenario that names none."""
PROFILES = ("wheel_1", "wheel_2", "rail_1", "rail_2")
"""Keys of ``profiles`` that name lateral profiles."""


def load_scenario(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """Load a scenario.

    Parameters
    ----------
    name_or_path
        Name of a shipped scenario, such as ``damage_wheel_1``, or path of a YAML file. Files that it names are found
        beside it, too.
    overrides
        Changes ``dotted.key=value``, such as ``speed=30`` or ``irregularities.0.h=0.001``; list indices count from 0.

    Returns
    -------
    Scenario
        Typed and checked whole. The content of files is part of it: it needs none of them any more.

    Raises
    ------
    InputError
        In one line with the dotted key, for anything that cannot be used.

    Examples
    --------
    >>> load_scenario("damage_wheel_1", ["speed=30", "track.pad.stiffness=9e7"]).track.pad.stiffness
    90000000.0
    """
    data = load_yaml("scenarios", name_or_path)
    if not isinstance(data, dict):
        raise InputError(f"{name_or_path} is not a mapping of scenario keys: see the shipped scenarios")
    if is_file(Path(name_or_path)):
        _find_all_beside(data, Path(name_or_path).parent)
    for change in overrides:
        override(data, change)
    take_in(data)
    return scenario_from(data)


def scenario_from(data: Mapping[str, Any]) -> Scenario:
    """Scenario from a plain mapping, in which models are names of shipped ones or mappings; raises InputError."""
    return read(Scenario, data, "")


def take_in(data: dict[str, Any]) -> None:
    """Put the content of files that people name in the place of their names; raises InputError."""
    for key in MODELS:
        _take_in_model(data, key, f"{key}s")
    for standing in _standing(data):
        _take_in_model(standing, "detector", "detectors")
    profiles = data.get("profiles")
    if isinstance(profiles, dict):
        for surface in filter(profiles.__contains__, PROFILES):
            profiles[surface] = with_points(surface.partition("_")[0], profiles[surface], f"profiles.{surface}")


def override(data: dict[str, Any], change: str) -> None:
    """Set one entry of nested mappings and lists by ``dotted.key=value``; the value is read as YAML."""
    assign(data, *change_of(change), "--set ")


def change_of(change: str, option: str = "--set") -> tuple[str, Any]:
    """Dotted key and plain value of ``dotted.key=value``; ``option`` names it in messages."""
    key, equals, text = change.partition("=")
    key = key.strip()
    if not equals or not key:
        raise InputError(
            f"{option} {change!r} is not of the form key=value, such as speed=30 or irregularities.0.h=0.001"
        )
    return key, parse(text, f"the value of {option} {key}")


def suspect(key: str, value: Any, where: str) -> None:
    """Issue an InputWarning for a value of a dotted key that looks as if it were in another unit."""
    of = quantity_at(key)
    if of is not None:
        of.suspect(where, value)


def assign(data: dict[str, Any], key: str, value: Any, where: str = "") -> None:
    """Set one entry of a scenario's plain mapping by its dotted key; messages begin with ``where`` and the key.

    A key within a track or wheelset that is a name, or left out, makes the content of that model part of the scenario.
    """
    model, dot, _ = key.partition(".")
    if dot and model in MODELS:
        named = data.get(model, MODELS[model])
        if isinstance(named, str):
            data[model] = load_yaml(f"{model}s", named)
        elif named is None:
            data.pop(model, None)
    put(data, key, value, where)


def _find_all_beside(data: dict[str, Any], folder: Path) -> None:
    """Give the files that a scenario names, and that are beside it, by their path from here."""
    places: list[tuple[Any, str]] = [*((data, model) for model in MODELS), (data.get("track"), "base")]
    profiles, irregularities, events = data.get("profiles"), data.get("irregularities"), data.get("events")
    for surface, profile in profiles.items() if isinstance(profiles, dict) else ():
        places += [(profiles, surface), (profile, "file")]
    items = [*irregularities] if isinstance(irregularities, list) else []
    for event in events if isinstance(events, list) else ():
        items += plain_brought(event)
    places += [(item, "file") for item in items]
    places += [(standing, "detector") for standing in _standing(data)]
    for place, key in places:
        if isinstance(place, dict):
            find_beside(place, key, folder)


def _standing(data: Mapping[str, Any]) -> list[Any]:
    """Entries of ``wayside``."""
    wayside = data.get("wayside")
    return [*wayside] if isinstance(wayside, list) else []


def find_beside(place: dict[str, Any], key: str, folder: Path) -> None:
    """Give the file that ``key`` names by its path from here, if it is in ``folder``."""
    name = place.get(key)
    if isinstance(name, str) and Path(name).suffix and is_file(folder / name):
        place[key] = str(folder / name)


def _take_in_model(place: Any, key: str, kind: str, depth: int = 0) -> None:
    """Put the content of a model's file in the place of its name, and that of the files that it is based on."""
    name = place.get(key) if isinstance(place, dict) else None
    if isinstance(name, str) and name not in shipped.names(kind) and _names_file(Path(name)):
        place[key] = load_yaml(kind, name)
    if isinstance(place, dict) and depth < MAX_DEPTH:
        _take_in_model(place.get(key), "base", kind, depth + 1)


def _names_file(path: Path) -> bool:
    """Whether a name means a file: one that exists, or that would be one by its suffix."""
    return path.suffix.lower() in (".yaml", ".yml", ".npz") or is_file(path)
