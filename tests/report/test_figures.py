import numpy as np
import pytest
from matplotlib import image
from matplotlib.figure import Figure

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.report import plot_run
from wheelset_track_sim.report.figures import (
    check_picture,
    detail,
    draw_forces,
    draw_stresses,
    new_figure,
    write_picture,
)


@pytest.fixture
def axes():
    return Figure().subplots()


@pytest.mark.slow
def test_picture(make_survey, tmp_path):
    path = plot_run(make_survey("damage_wheel_1", spikes=[(1.8, 300e3)]), tmp_path / "new" / "run.png")
    pixels = image.imread(path)
    assert pixels.shape == (800, 1200, 4)
    assert np.unique(pixels.reshape(-1, 4), axis=0).shape[0] > 50  # curves, not an empty sheet


def test_a_path_that_cannot_be_written(make_survey, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        plot_run(make_survey(length=2.7), tmp_path / "file" / "out.svg")


@pytest.mark.parametrize(("suffix", "begins"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".PDF", b"%PDF")])
def test_the_suffix_says_the_form_and_the_same_figure_makes_the_same_file(tmp_path, suffix, begins):
    def written(name):
        with new_figure(2.0, "title", "made by") as figure:
            figure.subplots().plot([0, 1])
            return write_picture(figure, tmp_path / f"{name}{suffix}").read_bytes()

    first, second = written("first"), written("second")
    assert first.startswith(begins)
    assert first == second
    with pytest.raises(InputError, match=r"out.gif is not a picture: give a name that ends in .png, .svg, .pdf"):
        check_picture(tmp_path / "out.gif")


def test_axes_say_quantity_and_unit(make_survey, axes):
    run = make_survey()
    draw_forces(axes, run, detail(run))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("position along the track (m)", "contact force (kN)")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["wheel 1", "wheel 2", "sleeper", "static"]
    (curve,) = (line for line in axes.lines if line.get_label() == "wheel 1")
    np.testing.assert_allclose(curve.get_ydata(), 100.0)


def test_sleepers_stand_at_whole_bays(make_survey, axes):
    run = make_survey("damage_both", spacing=0.7, spikes=[(1.4, 300e3)])
    draw_stresses(axes, run, detail(run).between(500, 3000))
    marks = [line.get_xdata()[0] for line in axes.lines if len(line.get_xdata()) == 2]
    np.testing.assert_allclose(marks, [0.7, 1.4, 2.1, 2.8])


def test_detail_is_the_passage_or_the_largest_force(make_survey):
    spikes = [(1.8, 300e3), (4.5, 320e3)]
    published = make_survey("damage_wheel_1", spikes=spikes)
    assert detail(published) is published.passage.samples
    other = make_survey("damage_both", spikes=spikes)
    shown = detail(other)
    assert shown.position[0] == pytest.approx(3.6)
    assert shown.position[-1] == pytest.approx(6.0)  # the end of the run
    assert shown.forces.max() == 320e3
