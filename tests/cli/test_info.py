"""What ``info`` shows on a narrow terminal."""

import dataclasses

import pytest

from support.paths import OLD_BAG
from wheelset_track_sim.bags.overview import ChangedKey, overview
from wheelset_track_sim.cli.console import terminal
from wheelset_track_sim.cli.info import tables


@pytest.mark.parametrize(
    "key", ["speed", "irregularities.10.harmonics.3.amplitude", "irregularities.0." + "deep." * 12]
)
def test_names_are_whole_at_80_columns(monkeypatch, key):
    monkeypatch.setenv("COLUMNS", "80")
    found = overview(OLD_BAG)
    changed = dataclasses.replace(found.revisions[1], changed=(ChangedKey(key, 0.001, [1.0] * 30),))
    found = dataclasses.replace(found, revisions=(found.revisions[0], changed))
    console = terminal()
    with console.capture() as captured:
        for table in tables(found):
            console.print(table)
    lines = captured.get().splitlines()
    assert max(map(len, lines)) <= 80
    columns = [[cell.strip() for cell in line.split("│")] for line in lines if line.startswith("│")]
    shown = "".join(row[3] for row in columns if len(row) == 7)
    assert shown == key
    assert set(found.topics) <= {cell for row in columns for cell in row}
