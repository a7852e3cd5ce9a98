"""Answers: the samples of a passage, the stress of turning points, the bodies in contact, and their messages."""

import dataclasses
from collections import OrderedDict

import numpy as np
import pytest

pytest.importorskip("bokeh", reason="the page needs the extra explore")

from support.exploring import toy_explorer, unpacked
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.explore.answers import _kept
from wheelset_track_sim.explore.messages import answer_message, moment_message, packed
from wheelset_track_sim.explore.view import View
from wheelset_track_sim.simulation.simulator import Simulator

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def explorer():
    return toy_explorer()


@pytest.fixture(scope="module")
def answer(explorer):
    view = dataclasses.replace(explorer.base.begin, kind="flat", flat=0.03, place=0.1)
    return explorer.answer(view)


def test_an_answer_has_the_bits_of_a_simulator(explorer, answer):
    scenario = explorer.base.scenario_of(answer.view)
    run = Simulator(explorer.base.surroundings(answer.view), models=explorer.models(scenario))
    run.settle()
    run.advance(900)
    run.apply(scenario, not_before=900, exactly=True)
    expected = run.advance(scenario.steps_per_revolution)
    assert len(answer.block) == scenario.steps_per_revolution
    assert np.array_equal(answer.block.forces, expected.forces)
    assert answer.scenario.irregularities == scenario.irregularities
    assert answer.position[answer.peak_row] == pytest.approx(0.1, abs=0.03)
    assert np.array_equal(answer.fixed, expected.stresses[:, :, 1])


def test_the_turning_point_of_an_undamaged_axle_goes_through_the_static_bending(explorer):
    answer = explorer.answer(dataclasses.replace(explorer.base.begin, kind="none"))
    assert answer.amplitude == pytest.approx(answer.undamaged, rel=0.02)
    assert np.ptp(answer.turning, axis=0) == pytest.approx(2 * answer.amplitude)
    assert answer.turning.min() < 0 < answer.fixed.min()


def test_bodies_touch_where_there_is_pressure(answer):
    moment = answer.moment(answer.peak_row)
    x, rail, wheel = moment.profiles()
    assert moment.patch.force == pytest.approx(answer.block.forces[answer.peak_row, 0], rel=1e-6)
    pressed = moment.patch.x[moment.patch.pressure.max(axis=1) > 0]
    inside = (x > pressed.min()) & (x < pressed.max())
    assert wheel[inside] == pytest.approx(rail[inside], abs=6e-5)  # elastic: tenths of a tenth of a millimetre
    assert wheel[0] - rail[0] == pytest.approx(0.08**2 / 2 / 0.4318, rel=0.05)
    assert moment.gap == 0.0
    lost = np.flatnonzero(answer.block.forces[:, 0] == 0)
    assert answer.contact_loss[0] == pytest.approx(len(lost) * answer.block.step_period)
    if len(lost):
        assert answer.moment(int(lost[0])).gap > 0


def test_messages_hold_what_the_page_draws(answer):
    message = unpacked(answer_message(7, answer))
    assert (message["kind"], message["number"], message["nodes"]) == ("answer", 7, ["A1", "B1", "C1"])
    assert View.read(dict(part.split("=") for part in message["query"].split("&"))).query() == answer.view.query()
    assert message["arrays"]["force0"] == pytest.approx(answer.block.forces[:, 0] / 1e3, rel=1e-6)
    assert message["arrays"]["stress2"] == pytest.approx(answer.turning[:, 2] / 1e6, rel=1e-5, abs=1e-4)
    assert message["readouts"]["wheel_1-peak"] == f"{answer.block.forces[:, 0].max() / 1e3:.0f} kN"
    row = answer.peak_row
    moment = unpacked(moment_message(7, row, answer, answer.moment(row)))
    columns, rows, _, _, dx, dy = moment["image"]
    image = moment["arrays"]["image"].reshape(rows, columns)
    force = 1e6 * np.nansum(image) * dx * dy * 1e-6
    assert force == pytest.approx(answer.block.forces[row, 0], rel=1e-3)
    assert f"wheel 1 at {answer.position[row]:.3f} m: {force / 1e3:.1f} kN" in moment["words"]


def test_a_message_cannot_hold_what_json_has_not():
    with pytest.raises(ValueError, match="JSON"):
        packed({"value": float("nan")})


def test_values_that_do_not_fit_are_refused(explorer):
    view = dataclasses.replace(explorer.base.begin, kind="worn_flat", flat=0.1, worn=0.05)
    with pytest.raises(InputError, match="worn_length"):
        explorer.answer(view)


def test_what_is_kept_does_not_grow():
    kept = OrderedDict()
    for number in (1, 2, 3, 2, 4):
        assert _kept(kept, number, 3, lambda number=number: -number) == -number
    assert [*kept] == [3, 2, 4]
    assert _kept(kept, 3, 3, lambda: 0) == -3
