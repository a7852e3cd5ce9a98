"""Pages as scripts: files that a page has its reader save, commands and Python, each with the lines that it shows."""

import contextlib
import io
import re
import runpy
import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path

from support.paths import ROOT
from wheelset_track_sim.cli import main

NAMED = re.compile(r"\b(?:as|in|of)\s+`([^`\s]+\.(?:py|yaml))`")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$|^((?:    \S[^\n]*\n)+)", re.MULTILINE | re.DOTALL)
TOP = ".venv/bin/"


@dataclass
class Part:
    """One block of a page: a file to save, a change of one, a command, Python, or printed lines."""

    kind: str
    text: str
    name: str = ""


def parts(page: Path) -> list[Part]:
    """Blocks of a page in their order.

    A block after a paragraph with "as `NAME`" is a file to save; a ``diff`` after one changes the file of that name.
    """
    text = page.read_text(encoding="utf-8") + "\n"
    found, end = [], 0
    for match in BLOCK.finditer(text):
        before, end = text[end : match.start()], match.end()
        kind, content, lines = match.groups()
        if lines:
            found += [Part("command", line.strip()) for line in lines.splitlines()]
        elif kind != "text" and (named := NAMED.search(before.rstrip().rpartition("\n\n")[2])):
            found.append(Part("diff" if kind == "diff" else "file", content, named[1]))
        else:
            found.append(Part(kind, content))
    return found


def follow(page: Path, left_out: tuple[str, ...] = ()) -> list[str]:
    """Do what a page says in the current folder, and demand every line that it shows; returns what was left out.

    Each printed line must be a line that was printed since the printed lines before, however it is spaced. A command
    may fail only if its message is shown. ``left_out`` are beginnings of commands that are not run: their
    printed lines are passed over.
    """
    printed, failed, names, skipped = "", "", {"__name__": "page"}, []
    unrun = False
    for part in parts(page):
        if part.kind == "file":
            Path(part.name).write_text(part.text, encoding="utf-8")
        elif part.kind == "diff":
            _change(Path(part.name), part.text)
        elif part.kind == "text" and unrun:
            unrun = False
        elif part.kind == "text":
            lines = {_spaced(line) for line in printed.splitlines()}
            shown = [_spaced(line) for line in part.text.splitlines() if line.strip() not in ("", "...")]
            assert [line for line in shown if line not in lines] == [], printed
            assert not failed or any(line.startswith("wheelset-track-sim: ") for line in shown), failed
            printed = failed = ""
        elif part.text.startswith(left_out):
            skipped.append(part.text)
            unrun = True
        elif part.kind in ("python", "command"):
            assert not failed, failed
            unrun = False
            out, errors = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
                if part.kind == "python":
                    exec(compile(part.text, str(page), "exec"), names)
                elif not _run(part.text):
                    failed = f"{part.text}: {errors.getvalue()}"
            printed += out.getvalue() + errors.getvalue()
    assert not failed, failed
    return skipped


def _spaced(line: str) -> str:
    return " ".join(line.split())


def _change(file: Path, diff: str) -> None:
    text = file.read_text(encoding="utf-8")
    for old, new in re.findall(r"((?:^-.*\n)+)((?:^\+.*\n)*)", diff, re.MULTILINE):
        before, after = (re.sub("^.", "", lines, flags=re.MULTILINE) for lines in (old, new))
        assert before in text, f"{file} has no lines {before}"
        text = text.replace(before, after, 1)
    file.write_text(text, encoding="utf-8")


def _run(line: str) -> bool:
    """Whether a command succeeds; files of the repository are found as from its folder."""
    program, *arguments = shlex.split(line, comments=True)
    arguments = [str(ROOT / each) if each.startswith(("config/", "examples/")) else each for each in arguments]
    if program == "mkdir":
        Path(arguments[-1]).mkdir(exist_ok=True)
    elif program == "cp":
        shutil.copy(*arguments)
    elif program == f"{TOP}python":
        runpy.run_path(str(Path(arguments[0]).absolute()), run_name="__main__")  # workers import it by its path
    else:
        assert program == f"{TOP}wheelset-track-sim", f"{line}: not a command that can be run here"
        return main(arguments) == 0
    return True
