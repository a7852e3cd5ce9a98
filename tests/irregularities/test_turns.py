"""One turn of a wheel from files that close it, go on, or drift."""

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.irregularities import Profile, tread_heights

N_C, DX = 2713, 1e-3
Y = np.zeros(1)


def height(angle: np.ndarray) -> np.ndarray:
    """Deviation of a tread, um."""
    return 30.0 * np.cos(np.radians(12 * angle)) + 8.0 * np.cos(np.radians(3 * angle + 40.0))


def written(path: Path, angle: np.ndarray, heights: np.ndarray) -> str:
    np.savetxt(path, np.column_stack([angle, heights]), "%.9g", ",", header="angle_deg,dev_um", comments="")
    return str(path)


def heights_of(file: str, **options: str) -> np.ndarray:
    """Heights of the tread, um."""
    return 1e6 * tread_heights([Profile("wheel_1", file, **options)], "wheel_1", N_C, DX, Y)[:, 0]


RIGHT = height(360.0 * np.arange(N_C) / N_C)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("turns")


@given(
    samples=st.integers(360, 2000),
    start=st.floats(0.0, 359.0),
    closed=st.booleans(),
    backwards=st.booleans(),
    wraps=st.booleans(),
)
def test_a_turn_is_closed_however_it_is_written(
    folder: Path, samples: int, start: float, closed: bool, backwards: bool, wraps: bool
) -> None:
    angle = start + 360.0 * np.arange(samples + closed) / samples
    angle = angle[::-1] if backwards else angle
    heights = height(angle)
    file = written(folder / "turn.csv", angle % 360.0 if wraps else angle, heights)
    np.testing.assert_allclose(heights_of(file), RIGHT, atol=0.02)


@given(
    turns=st.floats(1.02, 5.5),
    samples=st.integers(360, 1000),
    wraps=st.booleans(),
    noise=st.floats(0.0, 0.5),
    seed=st.integers(0, 2**32 - 1),
)
@pytest.mark.slow
def test_several_turns_are_named_and_averaged(
    folder: Path, turns: float, samples: int, wraps: bool, noise: float, seed: int
) -> None:
    count = round(turns * samples)
    assume(abs(count - samples) > 1)
    angle = 360.0 * np.arange(count) / samples
    heights = height(angle) + noise * np.random.default_rng(seed).standard_normal(count)
    file = written(folder / "turns.csv", angle % 360.0 if wraps else angle, heights)
    with pytest.raises(
        InputError, match=rf"turns.csv holds {count / samples:.3g} turns of the wheel: give one, or turns:"
    ):
        Profile("wheel_1", file)
    first, mean = (heights_of(file, turns=how) - RIGHT for how in ("first", "average"))
    assert np.abs(first).max() < 5.5 * noise + 0.02
    assert mean.std() < 1.15 * noise / np.sqrt(int(count / samples)) + 0.01


@given(
    drift=st.floats(-300.0, 300.0),
    samples=st.integers(720, 2000),
    start=st.floats(0.0, 359.0),
    closed=st.booleans(),
    noise=st.floats(0.0, 0.05),
)
@pytest.mark.slow
def test_drift_is_named_and_removed(
    folder: Path, drift: float, samples: int, start: float, closed: bool, noise: float
) -> None:
    angle = start + 360.0 * np.arange(samples + closed) / samples
    of = height(angle) + drift * np.arange(samples + closed) / samples
    of = of + noise * np.random.default_rng(1).standard_normal(len(of))
    file = written(folder / "drift.csv", angle, of)
    step = 400.0 / samples * 6.5  # above which the step at the seam is out of line with those of the waves
    assume(abs(abs(drift) - 5 * step) > 2 * step)
    named = abs(drift) > 5 * step
    with pytest.warns(InputWarning, match="from the end of the turn to its") if named else nullcontext():
        Profile("wheel_1", file)
    np.testing.assert_allclose(heights_of(file, drift="remove") - RIGHT, 0.0, atol=0.6)


def test_a_pure_drift_is_no_tread(folder: Path) -> None:
    """F10: 100 um of drift unloaded the wheel to 59.6 kN at the seam."""
    angle = np.arange(0.0, 360.0, 0.25)
    file = written(folder / "line.csv", angle, angle / 3.6)
    with pytest.warns(InputWarning, match="line.csv steps by 99.9 um .* other steps are below 0.0694 um"):
        assert np.ptp(heights_of(file)) > 99.0
    assert np.ptp(heights_of(file, drift="remove")) < 0.01


def test_drift_of_a_damaged_wheel_is_named(folder: Path) -> None:
    angle = np.arange(0.0, 360.0, 0.25)
    damage = -500.0 * (1.0 + np.cos(np.pi * np.clip((angle - 90.0) / 5.0, -1.0, 1.0)))
    whole = written(folder / "damaged.csv", angle, height(angle) + damage)
    right = heights_of(whole)
    file = written(folder / "damaged.csv", angle, height(angle) + damage + angle / 3.6)
    with pytest.warns(InputWarning, match="damaged.csv steps by"):
        Profile("wheel_1", file)
    np.testing.assert_allclose(heights_of(file, drift="remove"), right, atol=0.5)


def test_samples_without_an_order_are_sorted(folder: Path) -> None:
    angle = np.random.default_rng(4).permutation(np.arange(0.0, 360.0, 0.5))
    np.testing.assert_allclose(heights_of(written(folder / "mixed.csv", angle, height(angle))), RIGHT, atol=0.02)


def test_lengths_that_begin_again_are_turns(folder: Path) -> None:
    along = np.tile(np.arange(2713.0), 3)
    path = folder / "lengths.csv"
    np.savetxt(
        path,
        np.column_stack([along, height(along * 360.0 / 2713.0)]),
        "%.9g",
        ",",
        header="s [mm],dev [um]",
        comments="",
    )
    with pytest.raises(InputError, match="holds 3 turns"):
        Profile("wheel_1", str(path))
    for how in ("first", "average"):
        np.testing.assert_allclose(heights_of(str(path), turns=how), RIGHT, atol=0.02)


def test_missing_values_are_missing_in_the_mean_where_all_turns_miss_them(folder: Path) -> None:
    angle = np.arange(0.0, 1080.0, 0.5)
    heights = height(angle)
    heights[(angle > 100.0) & (angle < 104.0)] = np.nan  # in the first turn alone
    path = folder / "gaps.csv"
    path.write_text("angle [deg],dev [um]\n" + "".join(
        f"{a:g},{'' if np.isnan(h) else repr(float(h))}\n" for a, h in zip(angle, heights, strict=True)
    ))  # fmt: skip
    np.testing.assert_allclose(heights_of(str(path), turns="average"), RIGHT, atol=0.02)
    with pytest.raises(InputError, match="no value at"):
        Profile("wheel_1", str(path), turns="first")


@pytest.mark.parametrize(
    ("options", "refused"),
    [({"turns": "first"}, "turns applies to wheels"), ({"drift": "remove"}, "drift applies to wheels")],
)
def test_rails_do_not_turn(folder: Path, options: dict[str, str], refused: str) -> None:
    file = folder / "rail.csv"
    np.savetxt(file, np.column_stack([np.arange(300.0), np.sin(np.arange(300.0))]), header="s [mm] dev [um]")
    with pytest.raises(InputError, match=f"{refused}.* for rail_1"):
        Profile("rail_1", str(file), "mm", "um", **options)
