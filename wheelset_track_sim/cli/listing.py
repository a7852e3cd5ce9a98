"""``list``: what comes with the package, a line each."""

from __future__ import annotations

from rich.table import Table

from ..inputs import shipped
from .console import print_object, terminal


def listed(kind: str | None, *, json: bool) -> int:
    """Print names and descriptions of the shipped files of a kind, or of all; returns the exit status.

    Raises InputError for a kind that is not known.
    """
    kinds = shipped.kinds() if kind is None else [shipped.kind_of(kind)]
    found = {each: {name: shipped.description(each, name) for name in shipped.names(each)} for each in kinds}
    if json:
        rows = {each: [{"name": name, "description": text} for name, text in of.items()] for each, of in found.items()}
        print_object(rows)
        return 0
    for each, of in found.items():
        table = Table("name", "what it is", title=each, title_justify="left")
        table.columns[0].no_wrap = True
        for name, text in of.items():
            table.add_row(name, text)
        terminal().print(table)
    return 0
