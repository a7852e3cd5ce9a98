"""Text of the page: tables and numbers in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

Cell = str | float | None


def number(value: Cell, digits: int = 1) -> str:
    """A value with ``digits`` behind the point; text as it is, a dash for None."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    text = f"{value:.{digits}f}"
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text


def table(head: Sequence[str], rows: Iterable[Sequence[Any]], digits: Sequence[int] | int = 1) -> str:
    """Table with a line of heads; ``digits`` behind the point, one for all columns or one each."""
    each = [digits] * len(head) if isinstance(digits, int) else digits
    lines = [list(head), ["---", *["---:"] * (len(head) - 1)]]
    lines += [[number(cell, places) for cell, places in zip(row, each, strict=True)] for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def percent(ours: float, printed: float, digits: int = 1) -> str:
    """Difference of ours to printed as a share of the latter."""
    share = number(100 * (ours / printed - 1), digits)
    return f"{'' if share.startswith('-') else '+'}{share} %"


def exponent(value: float, digits: int = 1) -> str:
    """Value such as 4·10⁻⁴."""
    if value == 0:
        return "0"
    mantissa, _, power = f"{value:.{digits}e}".partition("e")
    return f"{mantissa}·10{str(int(power)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}"


def paragraphs(*parts: str) -> str:
    """Parts with a blank line between."""
    return "\n\n".join(part.strip("\n") for part in parts)
