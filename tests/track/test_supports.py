import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.track.supports import KINDS, Along, Scatter, SupportLine, Supports, along
from wheelset_track_sim.track.track import Track, load_track


def entry(**values: object) -> Along:
    return along(SupportLine(supports=(Supports(**values),)))  # type: ignore[arg-type]


def test_nothing_said_changes_nothing() -> None:
    line = along(SupportLine())
    for kind in KINDS:
        assert np.array_equal(getattr(line, kind), np.ones((80, 2)))
    assert np.isnan(line.gap).all()


@pytest.mark.parametrize(
    ("sleepers", "meant"), [(12, [12]), ("12", [12]), ("3-5", [3, 4, 5]), (" 3 - 4, 79 ", [3, 4, 79])]
)
def test_sleepers_are_named_one_by_one_or_in_stretches(sleepers: object, meant: list[int]) -> None:
    line = entry(sleepers=sleepers, on="rail_2", pad_stiffness=0.5, gap=0.001)
    assert np.flatnonzero(line.pad_stiffness[:, 1] == 0.5).tolist() == meant
    assert np.flatnonzero(line.gap[:, 1] == 0.001).tolist() == meant
    assert (line.pad_stiffness[:, 0] == 1.0).all()
    assert np.isnan(line.gap[:, 0]).all()


def test_a_ramp_goes_in_equal_ratios_on_both_sides_and_round_the_end() -> None:
    ballast = entry(sleepers="0-9", over=3, ballast_stiffness=16.0).ballast_stiffness[:, 0]
    assert ballast[:10] == pytest.approx(16.0)
    assert ballast[10:14] == pytest.approx([8.0, 4.0, 2.0, 1.0])
    assert ballast[-4:] == pytest.approx([1.0, 2.0, 4.0, 8.0])


def test_entries_multiply_and_the_larger_gap_holds() -> None:
    line = along(
        SupportLine(supports=(Supports("3-9", pad_damping=2.0, gap=0.002), Supports("5", pad_damping=1.5, gap=0.001)))
    )
    assert line.pad_damping[4:7, 0] == pytest.approx([2.0, 3.0, 2.0])
    assert line.gap[4:7, 1] == pytest.approx(0.002)
    limited = along(
        SupportLine(supports=(Supports("5", ballast_stiffness=100.0), Supports("5", ballast_stiffness=100.0)))
    )
    assert limited.ballast_stiffness[5, 0] == 100.0


def test_scatter_has_the_mean_and_the_variation_that_are_asked_for() -> None:
    line = along(SupportLine(bays=1000, scatter=Scatter(pad_stiffness=0.2, ballast_stiffness=0.5, seed=7)))
    for kind, variation in (("pad_stiffness", 0.2), ("ballast_stiffness", 0.5)):
        drawn = getattr(line, kind)
        assert drawn.mean() == pytest.approx(1.0, abs=4 * variation / np.sqrt(2000))
        assert drawn.std() == pytest.approx(variation, rel=0.15)
        assert abs(np.corrcoef(drawn.T)[0, 1]) < 0.15  # sides of their own
        assert abs(np.corrcoef(drawn[1:, 0], drawn[:-1, 0])[0, 1]) < 0.15
    assert np.corrcoef(line.pad_stiffness[:, 0], line.ballast_stiffness[:, 0])[0, 1] < 0.15
    assert (line.pad_damping == 1.0).all()


def test_a_seed_draws_the_same_and_another_one_others() -> None:
    one, again, other = (
        along(SupportLine(scatter=Scatter(pad_stiffness=0.2, seed=seed))).pad_stiffness for seed in (1, 1, 2)
    )
    assert np.array_equal(one, again)
    assert not np.isclose(one, other).any()
    # what is scattered besides does not change what is drawn
    both = along(SupportLine(scatter=Scatter(pad_stiffness=0.2, ballast_damping=0.3, seed=1))).pad_stiffness
    assert np.array_equal(one, both)


@given(st.floats(0.0, 1.0), st.integers(0, 2**31 - 1))
def test_scattered_supports_stay_within_their_limits(variation: float, seed: int) -> None:
    line = along(SupportLine(bays=48, scatter=Scatter(variation, variation, variation, variation, seed)))
    for kind in KINDS:
        assert np.all((getattr(line, kind) >= 1e-3) & (getattr(line, kind) <= 100.0))


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ({"supports": [{"sleepers": "9-3"}]}, r"track\.line\.supports\.0: sleepers = '9-3' cannot be read"),
        ({"supports": [{"sleepers": "all"}]}, "sleepers = 'all' cannot be read"),
        ({"supports": [{"sleepers": 1.5}]}, r"supports\.0\.sleepers = 1\.5"),
        ({"supports": [{"sleepers": 80}]}, "is beyond the line: give sleepers from 0 to 79"),
        ({"supports": [{"sleepers": 3, "pad_stiffness": 2e8}]}, "multiple of the track's from 0.001 to 100"),
        ({"supports": [{"sleepers": 3, "gap": 0.5}]}, "gap = 0.5 m is out of range: give 0 to 0.02 m"),
        ({"supports": [{"sleepers": 3, "on": "left"}]}, "'left' is not a known choice"),
        ({"supports": [{"sleeper": 3}]}, "did you mean sleepers"),
        ({"bays": 20}, "bays = 20 is out of range"),
        ({"scatter": {"pad_stiffness": -0.1}}, "coefficient of variation"),
    ],
)
def test_what_cannot_be_used_is_refused_by_name(line: dict, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        load_track({"base": "ballasted_60e1", "line": line})
    assert "\n" not in str(refused.value)


def test_slab_track_has_no_ballast_to_vary() -> None:
    slab = {"base": "slab_60e1", "line": {"supports": [{"sleepers": 3, "pad_stiffness": 0.5}]}}
    assert isinstance(load_track(slab), Track)
    for key, value in (("gap", 0.001), ("ballast_damping", 2.0)):
        with pytest.raises(InputError, match=r"line\.supports\.0 changes the ballast"):
            load_track({"base": "slab_60e1", "line": {"supports": [{"sleepers": 3, key: value}]}})
    assert isinstance(load_track({"base": "slab_60e1", "line": {"scatter": {"pad_damping": 0.2}}}), Track)
    for key in ("ballast_stiffness", "ballast_damping"):
        with pytest.raises(InputError, match=r"line\.scatter changes the ballast"):
            load_track({"base": "slab_60e1", "line": {"scatter": {key: 0.2}}})
