import re
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib import image
from matplotlib.figure import Figure

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.report import plot_run, write_report
from wheelset_track_sim.report.figures import curves, detail, draw_forces, draw_stresses
from wheelset_track_sim.report.table import comparison

ADDRESS = re.compile(r"""(?:src|href|url)\s*[=(]\s*["']?(?!#|["']?#)([^"')\s>]+)""")


class Elements(HTMLParser):
    """Checks that every element is closed, and collects what is asked for."""

    def __init__(self):
        super().__init__()
        self.stack, self.ids, self.counts = [], [], {}

    def handle_starttag(self, tag, attrs):
        self.counts[tag] = self.counts.get(tag, 0) + 1
        self.ids += [value for key, value in attrs if key == "id"]
        if tag not in ("meta", "br", "link"):
            self.stack.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert self.stack.pop() == tag


@pytest.fixture
def axes():
    return Figure().subplots()


def test_page_needs_nothing_else(make_recording, tmp_path):
    out = write_report(make_recording("damage_wheel_1", spikes=[(1.8, 300e3)]), tmp_path / "new" / "page.html")
    text = out.read_text(encoding="utf-8")
    page = Elements()
    page.feed(text)
    assert page.stack == []
    assert ADDRESS.findall(text) == []
    assert not {"script", "link", "img", "iframe"} & page.counts.keys()
    assert page.counts["svg"] == 8  # detail and whole, forces and stresses, wide and narrow
    for part in ("300.0 kN", "358 kN", "position along the track (m)", "contact force (kN)", "stress (MPa)", "digest"):
        assert part in text


def test_a_page_is_the_same_every_time(make_recording, tmp_path):
    recording = make_recording("undamaged", length=2.7)
    one, other = (write_report(recording, tmp_path / name).read_bytes() for name in ("one.html", "other.html"))
    assert one == other


def test_names_are_shown_and_never_run(make_recording, tmp_path):
    text = write_report(make_recording(name="<script>alert(1)</script>"), tmp_path / "page.html").read_text()
    assert "<script" not in text
    assert "&lt;script&gt;" in text


def test_picture(make_recording, tmp_path):
    path = plot_run(make_recording("damage_wheel_1", spikes=[(1.8, 300e3)]), tmp_path / "new" / "run.png")
    pixels = image.imread(path)
    assert pixels.shape == (800, 1200, 4)
    assert np.unique(pixels.reshape(-1, 4), axis=0).shape[0] > 50  # curves, not an empty sheet


@pytest.mark.parametrize("make", [plot_run, write_report])
def test_a_path_that_cannot_be_written(make, make_recording, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        make(make_recording(length=2.7), tmp_path / "file" / "out")


def test_axes_say_quantity_and_unit(make_recording, axes):
    recording = make_recording()
    draw_forces(axes, recording, slice(0, 3000))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("position along the track (m)", "contact force (kN)")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["wheel 1", "wheel 2", "sleeper", "static"]
    (curve,) = (line for line in axes.lines if line.get_label() == "wheel 1")
    np.testing.assert_allclose(curve.get_ydata(), 100.0)


def test_sleepers_stand_at_whole_bays(make_recording, axes):
    draw_stresses(axes, make_recording(spacing=0.7), slice(500, 3000))
    marks = [line.get_xdata()[0] for line in axes.lines if len(line.get_xdata()) == 2]
    np.testing.assert_allclose(marks, [0.7, 1.4, 2.1, 2.8])


def test_detail_is_the_passage_or_the_largest_force(make_recording):
    spikes = [(1.8, 300e3), (4.5, 320e3)]
    published = make_recording("damage_wheel_1", spikes=spikes)
    assert detail(published, comparison(published)) == comparison(published).passage
    other = make_recording("damage_both", spikes=spikes)
    shown = other.position[detail(other, None)]
    assert shown[0] < 4.5 < shown[-1]
    assert np.ptp(shown) == pytest.approx(2.7, abs=2e-3)
    assert detail(make_recording(length=3.0), None) == slice(0, 3001)


def test_a_long_run_keeps_its_peaks(make_recording, axes):
    recording = make_recording("damage_both", length=40.0, spikes=[(12.3456, 555e3)])
    curves(axes, recording, slice(0, len(recording)), recording.forces / 1e3, ("wheel 1", "wheel 2"))
    corners = np.concatenate([path.vertices for band in axes.collections for path in band.get_paths()])
    assert len(corners) < 0.2 * len(recording)
    assert corners[:, 1].max() == 555.0
    assert corners[:, 1].min() == 0.0
