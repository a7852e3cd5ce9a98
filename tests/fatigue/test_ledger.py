"""The ledger: entries by axle and run, merged without counting twice, in files that are always whole."""

import dataclasses

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.ledger import (
    KNOWN,
    LONGER,
    NEW,
    Basis,
    Ledger,
    LedgerEntry,
    changed_ledger,
    load_ledger,
    run_identity,
)
from wheelset_track_sim.fatigue.rainflow import GATE
from wheelset_track_sim.fatigue.static_stress import static_stress

CURVE = load_curve("assumed_body")
POINTS = 8
BASIS = Basis(CURVE, POINTS, GATE)
TURN = 2713


@pytest.fixture(scope="module")
def run():
    """A toy run: its blocks, and a count of it that begins anew."""
    simulator = toy_simulator(like="damage_wheel_1")
    static = static_stress(simulator.scenario, simulator.models.reduced, simulator.scenario.output.stress_nodes)

    def begin(mark=0.0):
        return AxleFatigue(static, TurningWheel.of(simulator.scenario), CURVE, points=POINTS, mark=mark)

    return [simulator.advance(TURN) for _ in range(6)], begin


def entry_of(run, blocks=slice(None), axle="7", name="monday", *, finished=True):
    every, begin = run
    fatigue = begin()
    for block in every[blocks]:
        fatigue.push(block)
    return LedgerEntry.of(fatigue, axle, name, "toy", finished=finished)


@pytest.fixture(scope="module")
def whole(run):
    return entry_of(run)


@pytest.fixture(scope="module")
def part(run):
    return entry_of(run, slice(0, 3), finished=False)


def test_the_same_steps_are_never_counted_twice(whole, part):
    ledger = Ledger(BASIS)
    assert [ledger.put(each) for each in (part, whole, whole, part)] == [NEW, LONGER, KNOWN, KNOWN]
    assert [each.steps for each in ledger.entries] == [6 * TURN]
    np.testing.assert_array_equal(ledger.total("7")[0].damage, whole.damage[0])


def test_parts_of_a_run_add_up_unless_they_overlap(run, part):
    ledger = Ledger(BASIS)
    ledger.put(part)
    assert ledger.put(entry_of(run, slice(3, 6))) == NEW
    assert ledger.total("7")[0].distance == pytest.approx(6 * TURN * 1e-3)
    with pytest.raises(InputError, match=r"steps 5426 to .* overlap with steps 0 to 8138"):
        ledger.put(entry_of(run, slice(2, 4)))


def test_runs_of_an_axle_add_up_and_axles_do_not(whole):
    ledger = Ledger(BASIS)
    for axle, name in (("7", "monday"), ("7", "tuesday"), ("8", "monday")):
        assert ledger.put(dataclasses.replace(whole, axle=axle, run=name)) == NEW
    assert ledger.axles == ("7", "8")
    twice, once = ledger.total("7")[0], ledger.total("8")[0]
    np.testing.assert_array_equal(twice.damage, 2 * once.damage)
    assert (twice.distance, twice.worst) == (2 * once.distance, once.worst)
    assert twice.ratios == pytest.approx(once.ratios, nan_ok=True)
    assert twice.equivalent_range == pytest.approx(once.equivalent_range)
    np.testing.assert_array_equal(ledger.matrix("7", "A1", 3), 2 * ledger.matrix("8", "A1", 3))


def test_merging_is_idempotent_and_has_no_order(whole, part, tmp_path):
    one, other = Ledger(BASIS), Ledger(BASIS)
    one.put(part)
    one.put(dataclasses.replace(whole, run="tuesday"))
    other.put(whole)
    both, reverse = Ledger(BASIS), Ledger(BASIS)
    assert both.merge(one) + both.merge(other) + both.merge(one) == [NEW, NEW, LONGER, KNOWN, KNOWN]
    reverse.merge(other)
    reverse.merge(one)
    assert both.to_bytes() == reverse.to_bytes()


def test_a_file_holds_all_bits(whole, part, tmp_path):
    path = tmp_path / "axle.ledger"
    for entry in (whole, dataclasses.replace(part, run="tuesday")):
        with changed_ledger(path, BASIS) as ledger:
            ledger.put(entry)
    again = load_ledger(path)
    assert again.basis == BASIS
    first, second = again.entries
    for field in dataclasses.fields(LedgerEntry):
        if field.name != "state":
            np.testing.assert_array_equal(getattr(first, field.name), getattr(whole, field.name))
    assert {name: array.tobytes() for name, array in second.state.items()} == {
        name: array.tobytes() for name, array in part.state.items()
    }
    assert again.to_bytes() == path.read_bytes()
    assert len(path.read_bytes()) < 200_000


def test_a_count_goes_on_from_the_ledger_bit_by_bit(run, whole, part, tmp_path):
    blocks, begin = run
    with changed_ledger(tmp_path / "axle.ledger", BASIS) as ledger:
        ledger.put(part)
    found = load_ledger(tmp_path / "axle.ledger").open_entry("7", "monday")
    fatigue = begin()
    fatigue.resume(found.state)
    assert fatigue.next_step == 3 * TURN
    for block in blocks[3:]:
        fatigue.push(block)
    entry = LedgerEntry.of(fatigue, "7", "monday", "toy", finished=True)
    for name in ("damage", "mark_damage", "mark_distance", "half_cycles", "cells", "amplitude"):
        assert getattr(entry, name).tobytes() == getattr(whole, name).tobytes(), name


def test_damage_over_distance_ends_with_all_of_it(whole):
    assert whole.mark_distance == pytest.approx(2.713 * np.arange(1, 7))
    np.testing.assert_array_equal(whole.mark_damage[-1], whole.damage)
    assert (np.diff(whole.mark_damage[..., 0].max(axis=(1, 2))) > 0).all()


def test_angles_count_from_the_mark_of_the_axle(run, whole):
    blocks, begin = run
    fatigue = begin(mark=np.pi / 4)  # one of 8 points further
    for block in blocks:
        fatigue.push(block)
    np.testing.assert_allclose(fatigue.damage, np.roll(whole.damage, -1, axis=1), rtol=1e-9)


def test_another_basis_is_refused(whole, tmp_path):
    weaker = dataclasses.replace(CURVE, fatigue_limit=100e6)
    with changed_ledger(tmp_path / "axle.ledger", BASIS) as ledger:
        ledger.put(whole)
    for basis, words in (
        (Basis(weaker, POINTS, GATE), "curve assumed_body, which damage by curve assumed_body with other constants"),
        (Basis(CURVE, 36, GATE), "points 8, which damage by points 36"),
    ):
        with pytest.raises(InputError, match=words), changed_ledger(tmp_path / "axle.ledger", basis):
            pass


def test_an_error_leaves_the_file_as_it_was(whole, tmp_path):
    path = tmp_path / "axle.ledger"
    with changed_ledger(path, BASIS) as ledger:
        ledger.put(whole)
    before = path.read_bytes()
    other = Ledger(BASIS)  # its first entry is new, the second one cannot be used
    other.put(dataclasses.replace(whole, axle="6"))
    other.put(dataclasses.replace(whole, first_step=TURN))
    with pytest.raises(InputError, match="overlap"), changed_ledger(path, BASIS) as ledger:
        ledger.merge(other)
    assert path.read_bytes() == before
    with pytest.raises(InputError, match="give another --ledger"), changed_ledger(tmp_path / "no" / "x.ledger", BASIS):
        pass


def test_what_is_no_ledger_is_refused_in_one_line(whole, tmp_path):
    path = tmp_path / "axle.ledger"
    with pytest.raises(RecordingError, match="cannot be read"):
        load_ledger(path)
    with changed_ledger(path, BASIS) as ledger:
        ledger.put(whole)
    content = path.read_bytes()
    for bad in (b"", b"text", content[: len(content) // 2]):
        path.write_bytes(bad)
        with pytest.raises(RecordingError, match="is no ledger"):
            load_ledger(path)


@pytest.mark.parametrize("name", ["", " ", "a\nb", "x" * 201])
def test_names_are_printable_and_short(run, name):
    with pytest.raises(InputError, match="is no name"):
        entry_of(run, slice(0, 1), axle=name)


def test_identity_is_that_of_scenario_and_time():
    assert run_identity("speed: 20", 0) == run_identity("speed: 20", 0)
    assert len({run_identity("speed: 20", 0), run_identity("speed: 21", 0), run_identity("speed: 20", 5)}) == 3


def test_a_long_run_has_few_marks(run):
    blocks, begin = run
    fatigue = begin()
    for turn in range(300):
        fatigue.push(dataclasses.replace(blocks[0], first_step=turn * TURN))
    distances, damage = fatigue.marks
    assert 64 <= len(distances) == len(damage) <= 128
    assert distances[-1] == pytest.approx(300 * 2.713)
