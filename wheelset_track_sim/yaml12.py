"""YAML 1.2, where ``on`` is a key and not a truth value, and ``1e-3`` a number and not a text."""

from __future__ import annotations

from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from .errors import InputError


def parse(text: str, where: str) -> Any:
    """Plain value of a YAML text; raises InputError naming ``where`` if it is not YAML."""
    try:
        return YAML(typ="safe", pure=True).load(text)
    except YAMLError as reason:
        raise InputError(f"{where} is not YAML ({' '.join(str(reason).split())}): correct it there") from None
    except ValueError as reason:  # a date or number that looks like one and is none
        raise InputError(f"{where} is not YAML ({reason}): correct it there") from None


def dump(value: Any) -> str:
    """A plain value as YAML text; ``parse`` gives it back, floats bit by bit."""
    out = StringIO()
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False
    yaml.dump(value, out)
    return out.getvalue()
