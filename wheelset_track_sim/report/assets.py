"""Words and style that pages share."""

from __future__ import annotations

from importlib.resources import files

PAPER = (
    "M. Maglio, A. Pieringer, J. C. O. Nielsen, T. Vernersson, “Wheel–rail impact loads and axle bending stress "
    "simulated for generic distributions and shapes of discrete wheel tread damage”."
)


def asset(name: str) -> str:
    """Text of a file beside this one."""
    return (files(__package__) / name).read_text(encoding="utf-8")


STYLE = asset("page.css")
"""Style sheet of a page, for light and dark, wide and narrow, and paper."""
