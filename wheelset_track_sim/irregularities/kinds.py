"""The kinds of irregularities: those of this package, and those that other packages register.

A package registers a kind through an entry point of the group ``wheelset_track_sim.irregularities``, named like the
kind's ``type``::

    [project.entry-points."wheelset_track_sim.irregularities"]
    wheel_burn = "my_package:WheelBurn"

The kind is a frozen dataclass that follows the ``Irregularity`` protocol. From then on it works wherever irregularities
are given: in scenario files, with ``--set``, in live changes, and in bags. In text, such a kind carries the name of its
package, so that a bag that is opened elsewhere can say what to install.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NamedTuple, cast

from ..errors import InputError
from ..inputs.schema import plain, read, unknown
from .breakout import Breakout
from .cluster import Cluster
from .corrugation import Corrugation
from .flat import Flat
from .head_defect import HeadDefect, Squat
from .joint import DippedWeld, Joint
from .measured import Profile
from .polygon import Polygon
from .roughness import Roughness
from .surface import Irregularity

GROUP = "wheelset_track_sim.irregularities"
MOST = 1000
"""Irregularities of a scenario at most."""
OWN: dict[str, type[Irregularity]] = {
    kind.type: kind
    for kind in (
        Breakout,
        Cluster,
        Flat,
        Polygon,
        Roughness,
        Profile,
        Corrugation,
        Squat,
        HeadDefect,
        Joint,
        DippedWeld,
    )
}
"""Kinds of this package by their ``type``."""


class Kind(NamedTuple):
    """A kind of irregularity."""

    factory: type[Irregularity]
    package: str
    """Name of the package that registered it; empty for the kinds of this package."""


def known_kinds() -> list[str]:
    """Names of all kinds that can be used here."""
    return [*OWN, *(name for name in _registered() if name not in OWN)]


@cache
def kind_named(name: str) -> Kind:
    """Return the kind of a name.

    Raises
    ------
    InputError
        If no package registers it, or the package that does so has no usable class for it.
    """
    if name in OWN:
        return Kind(OWN[name], "")
    found = _registered().get(name)
    if found is None:
        raise InputError(unknown("type", f"type = {name!r}", name, known_kinds()))
    package = found.dist.name if found.dist else found.value.partition(".")[0].partition(":")[0]
    try:
        factory = found.load()
    except Exception as reason:  # whatever the other package raises when it is imported
        raise InputError(
            f"type = {name!r} of the package {package} cannot be imported ({reason!r}): repair or reinstall it"
        ) from reason
    if not (isinstance(factory, type) and dataclasses.is_dataclass(factory)) or getattr(factory, "type", None) != name:
        raise InputError(f"type = {name!r}: {found.value} of the package {package} is not a dataclass of that type")
    names = {field.name for field in dataclasses.fields(factory)}
    if "on" not in names or "package" in names or not callable(getattr(factory, "patches", None)):
        raise InputError(
            f"type = {name!r}: {found.value} of the package {package} needs a field on, a method patches, and no field "
            "package: see the Irregularity protocol"
        )
    return Kind(cast("type[Irregularity]", factory), package)


def read_irregularity(data: Any, where: str) -> Irregularity:
    """Irregularity from a mapping with its ``type``; ``where`` is the dotted key that messages begin with.

    Raises
    ------
    InputError
        If the kind is not known here, with the name of the package to install if the mapping holds it, or if a key or
        value cannot be used.
    """
    if not isinstance(data, Mapping):
        if type(data) in {kind_named(name).factory for name in known_kinds()}:
            return data  # type: ignore[no-any-return]
        raise InputError(f"{where} = {data!r} is not a mapping: give type, on, and the keys of that type")
    given = {key: value for key, value in data.items() if key not in ("type", "package")}
    if "type" not in data:
        raise InputError(f"{where}.type is missing: known are {', '.join(known_kinds())}")
    name, package = str(data["type"]), data.get("package")
    if package and name not in known_kinds():
        raise InputError(f"{where}.type = {name!r} needs the package {package}, which is not installed: install it")
    try:
        factory = kind_named(name).factory
    except InputError as refusal:
        raise InputError(f"{where}.{refusal}") from refusal.__cause__
    return read(factory, given, where)


def read_irregularities(data: Any, where: str) -> tuple[Irregularity, ...]:
    """Irregularities from a list of mappings; raises InputError."""
    if isinstance(data, str) or not isinstance(data, Sequence):
        raise InputError(f"{where} = {data!r} is not a list: put its entries in brackets, or a dash before each")
    check_number(len(data))
    return tuple(read_irregularity(item, f"{where}.{index}") for index, item in enumerate(data))


def plain_irregularities(irregularities: Iterable[Irregularity]) -> list[Any]:
    """Plain mappings from which ``read_irregularities`` makes equal irregularities."""
    found = []
    for item in irregularities:
        package = kind_named(item.type).package
        mapping = plain(item)
        head = {"type": mapping.pop("type")} | ({"package": package} if package else {})
        found.append(head | mapping)
    return found


def check_number(count: int) -> None:
    """Raise InputError for more irregularities than a scenario may have."""
    if count > MOST:
        raise InputError(f"irregularities has {count} entries: give at most {MOST}")


@cache
def _registered() -> dict[str, EntryPoint]:
    return {found.name: found for found in entry_points(group=GROUP)}
