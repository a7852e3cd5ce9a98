import numpy as np
import pytest

from wheelset_track_sim.dynamics import line_bay_kernels
from wheelset_track_sim.track import bloch
from wheelset_track_sim.track import line as track_line
from wheelset_track_sim.track.line import TrackLine
from wheelset_track_sim.track.track import load_track

APART = np.array([0.0, 2.0, 75.0, 163.0, 292.0, 500.0, 800.0, 1500.0, 2000.0])


def line_of(base: str = "ballasted_60e1", *supports: dict, **line: object) -> TrackLine:
    return track_line.track_line(load_track({"base": base, "line": {"supports": list(supports), **line}}))


@pytest.mark.parametrize("base", ["ballasted_60e1", "slab_60e1", "ballasted_54e1"])
@pytest.mark.parametrize("x", [0.0, 0.137, 0.3])
def test_equal_supports_are_the_track_of_bloch_waves(base: str, x: float) -> None:
    line = line_of(base)
    exact = bloch.receptance(line.track, APART, x, x)
    for rail in range(2):
        error = np.abs(line.receptance(APART, (0, x), (rail, x)) - exact[rail][0]) / np.abs(exact[0][0])
        assert error[APART < 300].max() < 5e-4
        assert error.max() < 0.025


def test_a_response_elsewhere_and_across_a_sleeper() -> None:
    line = line_of()
    exact = bloch.receptance(line.track, APART[:6], 0.21, [0.25, 1.0, -2.2])[0]
    for row, x in zip(exact, (0.25, 1.0, 48.0 - 2.2), strict=True):
        assert np.abs(line.receptance(APART[:6], (0, 0.21), (0, x)) - row).max() < 2e-3 * np.abs(row).max()


def test_static_compliance_is_that_of_both_rails_loaded() -> None:
    line = line_of()
    x = np.array([0.0, 0.05, 0.3, 0.599, 21.3])
    exact = np.array([sum(bloch.receptance(line.track, 0.0, at, at))[0, 0].real for at in x])
    assert line.compliance(x) == pytest.approx(np.stack([exact, exact], axis=1), rel=1e-8)


def test_softer_supports_show_where_they_are_and_on_their_side() -> None:
    line = line_of("ballasted_60e1", {"sleepers": "38-42", "on": "rail_2", "ballast_stiffness": 0.25})
    near, far = line.compliance([40 * 0.6, 10 * 0.6])
    assert far[0] == pytest.approx(far[1], rel=1e-6)
    assert near[1] > 1.5 * far[1]
    assert far[0] < near[0] < 1.2 * far[0]  # the sleeper turns


def test_reciprocity_between_rails_and_places() -> None:
    line = line_of("ballasted_60e1", {"sleepers": 20, "on": "rail_1", "pad_stiffness": 0.2}, scatter={"seed": 3})
    one, two = (0, 12.1), (1, 13.0)
    assert line.receptance(APART, one, two) == pytest.approx(line.receptance(APART, two, one), rel=1e-9)


def test_modes_are_as_many_as_the_kernels_have_rows_for() -> None:
    line = line_of()
    assert line.size == line_bay_kernels.RAIL + 2 * line_bay_kernels.HALF
    assert len(line.span.modes) == line_bay_kernels.RAIL_MODES
    assert len(line.sleeper.stiffness) == 2 * line_bay_kernels.HALF
    assert line_of("slab_60e1").size == line_bay_kernels.RAIL
    flip = np.repeat([1.0, -1.0], line_bay_kernels.HALF)
    assert line.sleeper.seats[1] == pytest.approx(flip * line.sleeper.seats[0], rel=1e-9, abs=1e-12)
    assert line.sleeper.ballast[1] == pytest.approx(np.outer(flip, flip) * line.sleeper.ballast[0], abs=1e-9)


def test_stiffness_along_the_line_is_what_a_load_on_both_rails_finds() -> None:
    line = line_of("ballasted_60e1", {"sleepers": "30-50", "over": 4, "ballast_stiffness": 4.0})
    stiffness = line.stiffness(np.arange(80) * 0.6)
    assert stiffness.shape == (80, 2)
    assert np.all(stiffness[40] > 1.5 * stiffness[5])
    assert np.all(np.diff(stiffness[26:31], axis=0) > 0)
