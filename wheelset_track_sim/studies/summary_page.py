"""The summary of a study: in Markdown, with pictures beside it, and as one HTML page that needs no other file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from pathlib import Path

from ..report.figures import MADE_WITH
from ..report.files import PAPER, STYLE
from . import drawing
from .tables import ResultTable

MORE_STYLE = """
figure svg { min-width: 38rem; }
figure { overflow-x: auto; background: #fff; }
td, th { white-space: normal; }
"""
PRINTED = f"“Paper” is {PAPER}"


def write_summary(
    out: Path, title: str, description: str, made_by: str, tables: Sequence[ResultTable], files: Sequence[Path]
) -> list[Path]:
    """Write ``summary.md`` and ``summary.html`` into ``out``; ``files`` are the figures and tables written before.

    Raises InputError for a folder that cannot be written.
    """
    paths = [out / "summary.md", out / "summary.html"]
    texts = (
        _markdown(title, description, made_by, tables, files),
        _html(title, description, made_by, tables, files),
    )
    try:
        for path, text in zip(paths, texts, strict=True):
            path.write_text(text, encoding="utf-8")
    except OSError as reason:
        raise drawing.unwritable(out, reason) from None
    return paths


def _markdown(title: str, description: str, made_by: str, tables: Sequence[ResultTable], files: Sequence[Path]) -> str:
    parts = [f"# {title}", description.strip(), f"{made_by}. {MADE_WITH}."]
    for table in tables:
        parts.append(f"## {table.title}")
        lines = [table.headings, ("---",) * len(table.headings), *table.rows]
        parts.append("\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines))
    parts += [PRINTED] if any(table.title == "Beside the paper" for table in tables) else []
    pictures = [path for path in files if path.suffix == ".png"]
    parts += ["## Figures"] if pictures else []
    parts += [f"![{path.stem.replace('_', ' ')}]({path.name})" for path in pictures]
    data = [path for path in files if path.suffix == ".csv"]
    parts += ["## Data", "\n".join(f"- [{path.name}]({path.name})" for path in data)] if data else []
    return "\n\n".join(part for part in parts if part) + "\n"


def _html(title: str, description: str, made_by: str, tables: Sequence[ResultTable], files: Sequence[Path]) -> str:
    sections = [_table(table) for table in tables]
    if any(table.title == "Beside the paper" for table in tables):
        sections.append(f'<p class="quiet">{escape(PRINTED)}</p>')
    sections += [f"<figure>{_picture(path)}</figure>" for path in files if path.suffix == ".svg"]
    data = [path.name for path in files if path.suffix == ".csv"]
    if data:
        sections.append(f'<p class="quiet">Data in files beside this page: {escape(", ".join(data))}.</p>')
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{STYLE}{MORE_STYLE}</style>
</head>
<body>
<h1>{escape(title)}</h1>
<p>{escape(description)}</p>
<p class="quiet">{escape(made_by)}. {MADE_WITH}.</p>
{"".join(sections)}
</body>
</html>
"""


def _table(table: ResultTable) -> str:
    head = "".join(f"<th>{escape(heading)}</th>" for heading in table.headings)
    rows = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in table.rows)
    body = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return f'<h2>{escape(table.title)}</h2><div class="scroll">{body}</div>'


def _picture(path: Path) -> str:
    """Drawing as an element of the page; its identifiers get the name of the file, for they are the page's now."""
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{path.stem}-", text)
    return text.replace("<svg", f'<svg role="img" aria-label="{escape(path.stem.replace("_", " "))}"', 1)
