"""Frozen dataclasses whose numbers carry unit, limits and meaning, read from plain mappings and checked whole.

One declaration serves the scenario file, the ROS parameter descriptors and the documentation::

    @dataclass(frozen=True)
    class Pad:
        stiffness: float = quantity("N/m", 1e6, 1e10, "vertical stiffness")

        def __post_init__(self) -> None:
            check(self)

    pad = read(Pad, {"stiffness": 120e6}, "track.pad")
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

from ..errors import InputError, warn
from . import amounts

T = TypeVar("T")
_confirmed: ContextVar[bool] = ContextVar("confirmed", default=False)


@contextmanager
def confirmed_numbers() -> Iterator[None]:
    """Read bare numbers within as SI without doubt: they were read before, where a person gave them."""
    token = _confirmed.set(True)
    try:
        yield
    finally:
        _confirmed.reset(token)


@dataclass(frozen=True)
class Quantity:
    """What a number is: unit, closed limits, meaning."""

    unit: str
    low: float
    high: float
    meaning: str
    usual: tuple[float, float] | None = None
    """Usual sizes, SI. A bare number out of them that another unit brings into them is reported."""

    def refusal(self, where: str, value: Any) -> str | None:
        """One line that says why ``value`` cannot be used at ``where``, or None."""
        hint = ""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            found = f"{where} = {value!r} is not a number"
        elif not math.isfinite(value):
            found = f"{where} = {value} is not finite"
        elif not self.low <= value <= self.high:
            found = f"{where} = {value:g} {self.unit} is out of range".replace("  ", " ")
            limits = (self.low, self.high)
            meant = self._meant(value, *(self.usual or limits)) or self._meant(value, *limits)
            hint = f"; {meant[0]} would be {meant[1]}" if meant else ""
        else:
            return None
        return f"{found}: give {self.meaning or 'a value'} {self._limits}{hint}"

    @property
    def _limits(self) -> str:
        return f"from {self.low:g} to {self.high:g} {self.unit}".rstrip()

    def number(self, where: str, given: Any) -> Any:
        """SI number of what a person gives, which may be a text with a unit; what is neither is returned as it is.

        Raises InputError for a text that is no amount of this quantity, or is out of its limits. Issues an
        InputWarning for a bare number that is within the limits and looks as if it were in another unit.
        """
        if not isinstance(given, str):
            self.suspect(where, given)
            return given
        value = amounts.amount(given, self.unit, where)
        if not self.low <= value <= self.high:
            raise InputError(
                f"{where} = {given}, which is {value:.6g} {self.unit}".rstrip()
                + f", is out of range: give {self.meaning or 'a value'} {self._limits}"
            )
        return value

    def suspect(self, where: str, given: Any) -> None:
        """Issue an InputWarning for a bare number that can be used and looks as if it were in another unit."""
        if _confirmed.get() or self.usual is None or not given or self.refusal(where, given):
            return
        low, high = self.usual
        meant = None if low <= abs(given) <= high else self._meant(given, low, high)
        if meant:
            here = f"{given:g} {self.unit}"
            usual = amounts.in_unit(given, amounts.others(self.unit)[0], self.unit)
            warn(
                f"{where} = {given:g} is taken as {here} ({usual}), and looks like {meant[0]} ({meant[1]}): "
                f"write {meant[0]} if you mean that, and {here} otherwise"
            )

    def _meant(self, value: float, low: float, high: float) -> tuple[str, str] | None:
        """A bare number in the first other unit that brings it between limits, and what it then is in SI."""
        for name in amounts.others(self.unit) if self.unit or self.high <= 1 else ():  # percent is of shares
            meant = value * float(amounts.size_of(name, self.unit) or math.nan)
            if low <= (meant if low < 0 else abs(meant)) <= high and self.low <= meant <= self.high:
                return f"{value:g} {name}", f"{meant:.6g} {self.unit}"
        return None


def quantity(
    unit: str,
    low: float,
    high: float,
    meaning: str = "",
    *,
    default: Any = dataclasses.MISSING,
    usual: tuple[float, float] | None = None,
) -> Any:
    """Field of a frozen dataclass that holds a number with unit and limits; with a ``default`` of None, or None.

    ``usual`` are sizes that are usual in practice: see ``Quantity``.
    """
    field: Any = dataclasses.field
    return field(default=default, metadata={"quantity": Quantity(unit, low, high, meaning, usual)})


def parsed(reader: Callable[[Any, str], Any], writer: Callable[[Any], Any], **options: Any) -> Any:
    """Field of a frozen dataclass whose value has a form of its own in files.

    Parameters
    ----------
    reader
        Makes the value from plain data; its second argument is the dotted key, for messages. Raises InputError.
    writer
        Makes plain data from the value, from which ``reader`` makes an equal value.
    **options
        Of ``dataclasses.field``, such as ``default``.
    """
    field: Any = dataclasses.field
    return field(metadata={"reader": reader, "writer": writer}, **options)


def quantity_of(owner: type, name: str) -> Quantity:
    """Quantity declared for field ``name`` of dataclass ``owner``; KeyError if there is none."""
    found: Quantity = owner.__dataclass_fields__[name].metadata["quantity"]  # type: ignore[attr-defined]
    return found


def check(instance: Any, where: str = "") -> None:
    """Raise InputError naming the first number of a dataclass instance that is out of its limits."""
    prefix = f"{where}." if where else ""
    for field in dataclasses.fields(instance):
        refusal = _refusal(field, prefix + field.name, getattr(instance, field.name))
        if refusal:
            raise InputError(refusal)


def read(owner: type[T], data: Any, where: str) -> T:
    """Instance of dataclass ``owner`` from a mapping of plain values; ``where`` names it in messages.

    Raises InputError for a key that is unknown or missing, a wrong type, or a value out of its limits.
    """
    hints = _hints(typing.cast(Any, owner))
    if not isinstance(data, Mapping):
        raise InputError(f"{where} = {data!r} is not a mapping: give {', '.join(hints)}")
    fields = {field.name: field for field in dataclasses.fields(owner) if field.init}  # type: ignore[arg-type]
    for key in data:
        if key not in fields:
            raise InputError(unknown("key", f"{where}.{key}".lstrip("."), str(key), [*fields]))
    values: dict[str, Any] = {}
    for name, field in fields.items():
        path = f"{where}.{name}".lstrip(".")
        if name in data:
            given = _number(field, hints[name], path, data[name])
            refusal = _refusal(field, path, given)
            if refusal:
                raise InputError(refusal)
            reader = field.metadata.get("reader")
            values[name] = reader(given, path) if reader else value_as(hints[name], given, path)
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise InputError(f"{path} is missing: give it in {where or 'the file'}")
    try:
        return owner(**values)
    except InputError as refusal:
        if str(refusal).startswith(where):
            raise
        raise InputError(f"{where}: {refusal}") from None


def keyed(value: Any, where: str, what: str = "scenario keys") -> Mapping[str, Any]:
    """``value`` as a mapping whose keys are text; raises InputError that says ``what`` they are."""
    if not isinstance(value, Mapping):
        raise InputError(f"{where} = {value!r} is not a mapping of {what}")
    for key in value:
        if not isinstance(key, str):
            raise InputError(f"{where}: {key!r} is not text, and {what} must be: put it in quotes")
    return value


def plain(value: Any) -> Any:
    """Mappings, lists and numbers that ``read`` turns into an equal ``value``."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        kind = {"type": value.type} if hasattr(value, "type") else {}
        return kind | {
            field.name: field.metadata.get("writer", plain)(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if field.init
        }
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def unknown(what: str, where: str, name: str, known: Sequence[str]) -> str:
    """One line that refuses a name and lists those that are known, the nearest first."""
    near = difflib.get_close_matches(name, known, n=1)
    hint = f"did you mean {near[0]}? " if near else ""
    return f"{where} is not a known {what}: {hint}known are {', '.join(known) or 'none'}"


def _refusal(field: dataclasses.Field[Any], where: str, value: Any) -> str | None:
    declared: Quantity | None = field.metadata.get("quantity")
    if declared is None or (value is None and field.default is None):
        return None
    return declared.refusal(where, value)


def _number(field: dataclasses.Field[Any], hint: Any, where: str, given: Any) -> Any:
    """What is given for a field, in SI if that is a quantity; of a whole number, as one if it is one."""
    declared: Quantity | None = field.metadata.get("quantity")
    value = given if declared is None else declared.number(where, given)
    return int(value) if hint is int and value is not given and value.is_integer() else value


PLAIN: dict[Any, str] = {
    int: "a whole number",
    bool: "true or false",
    str: "a text, in quotes if it looks like a number",
}


@cache
def _hints(owner: Any) -> dict[str, Any]:
    return {name: hint for name, hint in typing.get_type_hints(owner).items() if name in owner.__dataclass_fields__}


def value_as(hint: Any, data: Any, where: str) -> Any:
    """``data`` as the type that an annotation names; raises InputError, which begins with ``where``."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        if data not in arguments:
            raise InputError(unknown("choice", f"{where} = {data!r}", str(data), [str(item) for item in arguments]))
        return data
    if origin in (typing.Union, types.UnionType):
        return _one_of(arguments, data, where)
    if origin is tuple:
        if isinstance(data, str) or not isinstance(data, Sequence):
            raise InputError(f"{where} = {data!r} is not a list: put its entries in brackets, or a dash before each")
        if arguments[1:] != (...,) and len(data) != len(arguments):
            raise InputError(f"{where} has {len(data)} entries: give {len(arguments)}")
        hints = [arguments[0]] * len(data) if arguments[1:] == (...,) else arguments
        return tuple(
            value_as(item, entry, f"{where}.{index}")
            for index, (item, entry) in enumerate(zip(hints, data, strict=True))
        )
    if dataclasses.is_dataclass(hint):
        if isinstance(data, hint):  # type: ignore[arg-type]
            return data
        return _one_of((hint,), data, where) if hasattr(hint, "type") else read(hint, data, where)  # type: ignore[arg-type]
    if hint is float:
        if isinstance(data, bool) or not isinstance(data, (int, float)) or not math.isfinite(data):
            raise InputError(f"{where} = {data!r} is not a finite number: give one")
        return float(data)
    if hint in (int, bool, str) and type(data) is not hint:
        raise InputError(f"{where} = {data!r} is not of type {hint.__name__}: give {PLAIN[hint]}")
    return data


def _one_of(arguments: tuple[Any, ...], data: Any, where: str) -> Any:
    """``data`` as one of the members of a union: None, plain types, or dataclasses told apart by their ``type``."""
    if data is None and type(None) in arguments:
        return None
    kinds = {kind.type: kind for kind in arguments if hasattr(kind, "type")}
    if isinstance(data, Mapping) and kinds:
        if "type" not in data:
            raise InputError(f"{where}.type is missing: known are {', '.join(kinds)}")
        if not isinstance(data["type"], str) or data["type"] not in kinds:
            raise InputError(unknown("type", f"{where}.type = {data['type']!r}", str(data["type"]), [*kinds]))
        return read(kinds[data["type"]], {key: item for key, item in data.items() if key != "type"}, where)
    members = [kind for kind in arguments if kind is not type(None)]
    if len(members) == 1:
        return value_as(members[0], data, where)
    plain = [kind for kind in arguments if dataclasses.is_dataclass(kind)]
    if len(plain) == 1 and isinstance(data, Mapping):
        return value_as(plain[0], data, where)
    for argument in arguments:
        if argument is type(data) or (argument is float and type(data) is int):
            return value_as(argument, data, where)
    names = ", ".join(getattr(argument, "__name__", str(argument)) for argument in arguments)
    raise InputError(f"{where} = {data!r} is not of type {names}")
