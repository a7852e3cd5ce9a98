"""A report of a damaged bag: of all that can be read, with what cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from wheelset_track_sim.bags import Bag, BagWriter, Gap, blocks
from wheelset_track_sim.cli import main
from wheelset_track_sim.report import survey

SPIKES = [(1.0, 300e3), (4.0, 280e3), (7.5, 310e3)]
LOST = slice(2778, 5556)
"""Steps of the blocks that are left out: the second impact is among them."""


def without(whole, path, lost):
    bag = Bag(whole)
    with BagWriter(path, bag.info, start_ns=0) as writer:
        writer.write_state(bag.states[0])
        for block in blocks(whole):
            if not lost.start <= block.first_step < lost.stop:
                writer.write(block)
    return path


@pytest.fixture
def bags(make_bag, tmp_path):
    """A whole bag, and the same without two blocks."""
    whole = make_bag(tmp_path / "whole.mcap", "damage_wheel_1", 9.0, SPIKES)
    return whole, without(whole, tmp_path / "run.mcap", LOST)


def test_figures_are_of_what_is_there(bags):
    whole, damaged = map(survey, bags)
    assert whole.losses == ()
    assert damaged.losses == (Gap(2778, 2778, pytest.approx(2778 * 36e-6)),)
    assert damaged.steps == whole.steps - 2778
    assert damaged.duration == pytest.approx(whole.duration - 2778 * 36e-6)
    assert damaged.end == whole.end
    first, _, last = whole.impacts
    assert damaged.impacts[0] == first
    assert [replace(item, contact_loss=0.0) for item in damaged.impacts[1:]] == [replace(last, contact_loss=0.0)]
    assert damaged.peak == whole.peak
    assert damaged.passage is not None  # it ends before the gap
    assert damaged.passage.summary == whole.passage.summary
    bins, other = damaged.bins, whole.bins
    np.testing.assert_array_equal(np.isnan(bins.low[:, 0]), np.isin(np.arange(len(bins)), np.r_[LOST]))
    for mine, theirs in ((bins.low, other.low), (bins.high, other.high)):
        there = ~np.isnan(mine)
        np.testing.assert_array_equal(mine[there], theirs[there])
    assert damaged.spectrum is not None
    assert np.isfinite(damaged.spectrum.density).all()


def test_a_passage_that_is_not_whole_is_not_compared_with_the_paper(bags, tmp_path):
    assert survey(without(bags[0], tmp_path / "other.mcap", slice(1389, 2778))).passage is None


@pytest.mark.slow
def test_page_and_terminal_name_what_is_missing(bags, tmp_path, capsys):
    assert main(["report", str(bags[1]), "--out", str(tmp_path / "page.html")]) == 0
    assert "lost: steps 2778 to 5555 are missing (0.1 s)" in capsys.readouterr().out
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "This bag is not whole" in page
    assert "steps 2778 to 5555 are missing" in page
