"""Write docs/reference/api.md from the docstrings of the names in ``wheelset_track_sim.__all__``.

python -m tools.api_page
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import wheelset_track_sim as wts

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "api.md"
HEAD = """# Python: the names of `wheelset_track_sim`

<!-- made from the docstrings by: python -m tools.api_page -->

    import wheelset_track_sim as wts

These names are all that the common jobs need. Everything is in SI units and radians; shapes are in parentheses.
Anything else in the package is private to it: it may change from release to release.

"""


def page() -> str:
    """Text of the page."""
    names = [name for name in wts.__all__ if not name.startswith("_")]
    index = "".join(f"* [`{name}`](#{name.lower()}): {_summary(name)}\n" for name in names)
    return HEAD + index + "".join(_section(name) for name in names)


def _summary(name: str) -> str:
    text = inspect.getdoc(getattr(wts, name)) or ""
    return " ".join(text.partition("\n\n")[0].split()).replace("``", "`")


def _section(name: str) -> str:
    found = getattr(wts, name)
    signature = "" if issubclass(type(found), type) and issubclass(found, Exception) else _signature(name, found)
    return f"\n## {name}\n{signature}\n{_markdown(inspect.getdoc(found) or '')}\n{_members(found)}"


def _members(found: object) -> str:
    """Methods and properties of a class with their first lines."""
    if not inspect.isclass(found) or issubclass(found, Exception):
        return ""
    items = []
    for name, member in vars(found).items():
        text = inspect.getdoc(getattr(member, "func", member))
        if (
            name.startswith("_")
            or not text
            or not (callable(member) or hasattr(member, "fget") or hasattr(member, "func"))
        ):
            continue
        arguments = ", ".join(list(inspect.signature(member).parameters)[1:]) if inspect.isfunction(member) else None
        called = name if arguments is None else f"{name}({arguments})"
        items.append(f"* `{called}`: {' '.join(text.partition(chr(10) * 2)[0].split()).replace('``', '`')}\n")
    return "\n**Methods and properties**\n\n" + "".join(items) if items else ""


def _signature(name: str, found: object) -> str:
    text = str(inspect.signature(found))  # type: ignore[arg-type]
    text = re.sub(r"(: |-> )([\"'])(.*?)\2(?=[,)]| =|$)", r"\1\3", text).removesuffix(" -> None")
    arguments, _, result = text.partition(" -> ")
    parts = re.split(r", (?![^\[(]*[\])])", arguments.strip("()"))
    one = f"wts.{name}({', '.join(parts)})" + (f" -> {result}" if result else "")
    if len(one) > 100:
        one = f"wts.{name}(\n" + "".join(f"    {part},\n" for part in parts) + ")" + (f" -> {result}" if result else "")
    return "\n" + "\n".join(f"    {line}" for line in one.splitlines()) + "\n"


def _markdown(text: str) -> str:
    """A docstring with sections in the style of numpy as Markdown."""
    text = text.replace("``", "`")
    sections = re.split(r"(?m)^(\w+)\n-+\n", text)
    lines = [sections[0].strip()]
    for title, body in zip(sections[1::2], sections[2::2], strict=True):
        if title == "Examples":
            lines.append("**Example**\n\n" + "\n".join(f"    {line}".rstrip() for line in body.strip().splitlines()))
            continue
        entries = re.split(r"(?m)^(?=\S)", body.strip())
        items = []
        for entry in filter(None, entries):
            head, _, rest = entry.partition("\n")
            items.append(f"* `{head.strip()}`: {' '.join(rest.split())}" if rest else f"* {head.strip()}")
        lines.append(f"**{title}**\n\n" + "\n".join(items))
    return "\n\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
