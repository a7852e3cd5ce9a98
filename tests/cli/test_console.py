"""No text from a file does anything to a terminal."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.table import Table

from wheelset_track_sim.cli.console import print_object, terminal
from wheelset_track_sim.errors import InputError, RecordingError, WheelsetTrackError, printable

HARMFUL = ["\x1b]0;title\x07", "\x1b[2J", "\x9b31m", "\r", "\x08", "\u202e", "\u2066", "\udcff", "\x00", "\x7f"]
anything = st.text() | st.lists(st.sampled_from([*HARMFUL, "run", " ", "[bold]"])).map("".join)


def plain(text):
    """Whether all characters of a text are printed as they are."""
    return not any(unicodedata.category(each) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp") for each in text)


@given(anything)
def test_printable_text_is_one_plain_line_and_says_all(text):
    assert plain(printable(text))
    assert printable(printable(text)) == printable(text)
    assert printable(text) == text or "\\" in printable(text)


@given(anything)
def test_a_terminal_prints_names_in_text_titles_and_tables_plainly(text):
    console = terminal()
    table = Table("name", text, title=text, caption=text)
    table.add_row(text, "1")
    with console.capture() as captured:
        console.print(text, soft_wrap=True)
        console.print(table)
        console.print(f"lost: {text}", highlight=False, soft_wrap=True)
    assert all(plain(line) for line in captured.get().split("\n"))


@pytest.mark.parametrize("text", HARMFUL)
def test_an_object_on_a_terminal_is_plain(text, monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")  # no colours
    print_object({text: [text]})
    assert all(plain(line) for line in capsys.readouterr().out.split("\n"))


@given(anything)
@pytest.mark.parametrize("kind", [InputError, RecordingError, WheelsetTrackError])
def test_errors_are_one_plain_line(kind, text):
    assert plain(str(kind(f"name = {text} is none")))
