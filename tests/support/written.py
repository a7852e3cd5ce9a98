"""Tables as other programs write them: the same numbers in many forms of text."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hypothesis import strategies as st

ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252")
HEADINGS = ("{name} [{unit}]", "{name} ({unit})", "{name}/{unit}", "{name}_{unit}", "{name} {unit}", "{name}[{unit}]")
SPELLINGS = {"um": ("um", "µm", "μm"), "deg": ("deg", "°", "degrees"), "dB": ("dB", "dB re 1 µm")}
PREAMBLES = (
    (),
    ("# measured by hand, at 20 °C",),
    ("% a comment", "", "! another"),
    ("[HEADER]", "H01=Wheelset:\t7", "[MeasurementData]"),
    ("Instrument: gauge 3, serial 42", "Operator=M. Müller", ""),
)


@dataclass(frozen=True)
class Form:
    """How a table is written."""

    separator: str = ","
    decimal: str = "."
    encoding: str = "utf-8"
    heading: str = HEADINGS[0]
    spelling: int = 0
    preamble: Sequence[str] = ()
    newline: str = "\n"
    quoted: bool = False
    units_below: bool = False
    ends: bool = False
    """Whether a separator is at the end of each line."""

    def text(self, names: Sequence[str], units: Sequence[str], rows: Sequence[Sequence[float]]) -> str:
        spelled = [(of := SPELLINGS.get(unit, (unit,)))[self.spelling % len(of)] for unit in units]
        if self.separator == " ":
            spelled = [unit.partition(" ")[0] for unit in spelled]
        if self.units_below:
            above = [[*names], [f"[{unit}]" for unit in spelled]]
        else:
            above = [[self.heading.format(name=name, unit=unit) for name, unit in zip(names, spelled, strict=True)]]
        cells = [[f"{value!r}".replace(".", self.decimal) for value in row] for row in rows]
        if self.separator == " ":
            lines = [" ".join(cell.replace(" ", "_") for cell in row) for row in (*above, *cells)]
        else:
            out = io.StringIO()
            quoting = csv.QUOTE_ALL if self.quoted else csv.QUOTE_MINIMAL
            ends = [""] if self.ends else []
            csv.writer(out, delimiter=self.separator, quoting=quoting, lineterminator="\n").writerows(
                [*row, *ends] for row in (*above, *cells)
            )
            lines = out.getvalue().splitlines()
        return self.newline.join([*self.preamble, *lines, ""])

    def write(self, path: Path, names: Sequence[str], units: Sequence[str], rows: Sequence[Sequence[float]]) -> Path:
        encoding = self.encoding
        text = self.text(names, units, rows)
        if encoding == "cp1252":
            text = text.replace("μ", "µ")  # of both micros it has one
        path.write_bytes(text.encode(encoding))
        return path


def forms() -> st.SearchStrategy[Form]:
    """All forms that can be told apart; commas that separate leave points to be the decimal mark, unless quoted."""
    marks = st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")])
    return st.builds(
        lambda mark, quoted, below, heading, ends, **rest: Form(
            *mark,
            quoted=quoted and mark[0] != " ",
            units_below=below,
            heading="{name}_{unit}" if mark[0] == " " else heading,
            ends=ends and mark[0] != " ",
            **rest,
        ),
        mark=marks,
        quoted=st.booleans(),
        below=st.booleans(),
        ends=st.booleans(),
        encoding=st.sampled_from(ENCODINGS),
        heading=st.sampled_from(HEADINGS),
        spelling=st.integers(0, 2),
        preamble=st.sampled_from(PREAMBLES),
        newline=st.sampled_from(["\n", "\r\n", "\r"]),
    )
