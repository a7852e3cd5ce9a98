import numpy as np
import pytest

from wheelset_track_sim.contact import (
    ContactGeometry,
    approach_for_force,
    build_contact_law,
    contact_force,
    windows,
)
from wheelset_track_sim.contact.law_kernels import tabulated_force
from wheelset_track_sim.irregularities import (
    Breakout,
    Corrugation,
    DippedWeld,
    Flat,
    Harmonic,
    HeadDefect,
    Polygon,
    Roughness,
    Squat,
)

DX, N_C = 0.001, 2713
GEOMETRY = ContactGeometry()


@pytest.fixture(scope="module", autouse=True)
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path_factory.mktemp("models")))
        yield


def law_of(*shapes, rail_steps=6000, **options):
    return build_contact_law(shapes, GEOMETRY, DX, N_C, rail_steps=rail_steps, **options)


def test_a_defect_of_a_rail_has_tables_like_one_of_a_tread():
    on_tread = law_of(Breakout("wheel_1", 0.010, 0.008, 0.0004))
    on_rail = law_of(HeadDefect("rail_1", 3.0, 0.010, 0.008, 0.0004))
    assert len(on_tread.first_point) == len(on_rail.first_point)
    for offset in (-9, 0, 4):
        approach = approach_for_force(on_tread, 0, offset, 0, 90e3)
        found = tabulated_force(on_rail, 0, 500, 3000 + offset, approach, 0.0)
        assert found == pytest.approx(90e3, rel=1e-9)


@pytest.mark.slow
def test_where_both_have_something_the_contact_is_solved_and_is_right():
    shapes = (Breakout("wheel_1", 0.010, 0.008, 0.0004), Squat("rail_1", 3.0, 0.012, 0.008, 0.0003))
    law, plain = law_of(*shapes), law_of(*shapes, tables=False)
    assert (law.table >= 0).all()
    assert (law.rail_table >= 0).all()
    assert len(law.nested[0].element) > 0
    approach = approach_for_force(plain, 0, 2, 3001, 120e3)
    assert np.isnan(tabulated_force(law, 0, 2, 3001, approach, 0.0))
    assert contact_force(law, 0, 2, 3001, approach, 0.0) == pytest.approx(120e3, rel=1e-9)
    assert tabulated_force(law, 0, 2, 100, approach, 0.0) == pytest.approx(
        contact_force(plain, 0, 2, 100, approach, 0.0), rel=1e-9
    )


@pytest.mark.slow
def test_waves_of_whole_steps_have_tables_and_their_ramps_are_solved():
    law = law_of(Corrugation("rail_1", wavelength=0.040, amplitude=1.5e-5, start=1.0, length=4.0, ramp=0.5))
    core = law.rail_table[0, 1600:4400]
    assert (core > 0).all()
    assert len(np.unique(core)) <= 40  # one for each place on a wave
    assert (law.rail_table[0, 1100:1400] == -1).all()
    assert (law.rail_table[0, :900] == 0).all()
    assert (law.rail_table[1] == 0).all()
    other = law_of(Corrugation("rail_1", wavelength=0.0453, amplitude=1.5e-5, start=1.0, length=4.0, ramp=0.5))
    assert (other.rail_table[0, 1100:4900] == -1).all()
    assert (law_of(DippedWeld("rail_1", 3.0, depth=0.0003)).rail_table[0, 2600:3400] == -1).all()


@pytest.mark.slow
def test_a_short_deep_shape_has_all_its_tables():
    assert (law_of(Flat("wheel_1", 0.060)).table >= 0).all()
    assert (law_of(Roughness("wheel_1")).table[0] == -1).all()


@pytest.mark.parametrize(
    "shape", [Polygon("wheel_1", (Harmonic(1, 1e-3),)), DippedWeld("rail_1", 3.0, 0.002, length=4.0)]
)
def test_long_waves_of_any_height_leave_the_contact_area_small(shape):
    smooth, long = law_of(tables=False), law_of(shape, tables=False)
    assert len(long.x) <= len(smooth.x) + 12
    assert long.tread.min() + long.rail.min() < -9e-4
    # What lies lower as a whole bears the same with so much more approach.
    for tread, rail in ((1356, 3000), (0, 3000)):
        lower = long.tread[0, tread, 0] + long.rail[long.rail_row[0, rail], 0]
        approach = approach_for_force(smooth, 0, 0, 0, 98e3) - lower
        assert contact_force(long, 0, tread, rail, approach, 0.0) == pytest.approx(98e3, rel=0.01)


def test_a_kilometre_of_line_takes_little_memory():
    law = law_of(Squat("rail_1", 900.0, 0.012, 0.008, 0.0003), rail_steps=1_000_000, tables=False)
    assert sum(each.nbytes for each in law if isinstance(each, np.ndarray)) < 60e6
    assert contact_force(law, 0, 0, 900_000, 5e-5, 0.0) < contact_force(law, 0, 0, 100, 5e-5, 0.0)


def test_surfaces_that_are_rough_all_along_are_left_out_alike(monkeypatch):
    """What one look at the middle tells is what all rows tell."""
    random = np.random.default_rng(1)
    treads = np.stack([1e-6 * random.standard_normal((2713, 5)), np.zeros((2713, 5))])
    treads[1, 100:120] = -1e-4
    rail = np.vstack([np.zeros((1, 5)), 1e-6 * random.standard_normal((1200, 5))])
    rows = np.stack([np.arange(1, 1201), np.zeros(1200)]).astype(np.int32)
    separation = np.stack([np.add.outer(np.linspace(-3, 3, 7) ** 2, np.linspace(-2, 2, 5) ** 2)] * 2) * 1e-6
    quick = windows.windows(treads, rows, rail, separation, 5e-5)
    monkeypatch.setattr(windows, "_rough_all_along", lambda middle: False)
    whole = windows.windows(treads, rows, rail, separation, 5e-5)
    assert (quick.tread[0] == -1).all()
    assert (quick.rail[0] == -1).all()
    assert quick.tread[1].max() > 0
    for one, other in zip(quick, whole, strict=True):
        assert np.array_equal(one, other)
