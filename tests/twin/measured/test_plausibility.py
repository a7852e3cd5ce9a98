"""Loads that no wheel has, and how to say what they are."""

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.runtime.arrays import Real
from wheelset_track_sim.twin.measured import Reading, read_measurement


def load(static: float, seed: int) -> Real:
    """Contact force of a wheel with an impact, N: noise of 1 %, ripple of 5 %, a peak of 60 %."""
    at = np.arange(400)
    ripple = 0.05 * np.sin(2 * np.pi * at / 60) + 0.6 * np.exp(-(((at - 200) / 4) ** 2))
    return np.asarray(static * (1.0 + ripple + 0.01 * np.random.default_rng(seed).standard_normal(400)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("loads")


def written(folder: Path, first: Real, second: Real, unit: str = "kN") -> Path:
    path = folder / "forces.csv"
    rows = np.column_stack([np.arange(len(first)) * 1e-4, first, second])
    np.savetxt(path, rows, "%.9g", ",", header=f"time [s],wheel_1 [{unit}],wheel_2 [{unit}]", comments="")
    return path


LOADS = st.floats(12e3, 160e3)
SEEDS = st.integers(0, 2**32 - 1)


@given(static=LOADS, seed=SEEDS)
def test_loads_of_wheels_are_read_without_a_word(folder: Path, static: float, seed: int) -> None:
    force = load(static, seed)
    found = read_measurement(written(folder, force / 1e3, force / 1e3))
    np.testing.assert_allclose(found.signals["wheel_1"], force, rtol=1e-8)


@given(static=st.floats(5.5e3, 160e3), seed=SEEDS, file=st.sampled_from(["N", "kN"]))
def test_another_unit_is_recognised_and_given(folder: Path, static: float, seed: int, file: str) -> None:
    """F7: N called kN made stresses of 77 GPa."""
    force, (says, scale) = load(static, seed), {"N": ("kN", 1.0), "kN": ("N", 1e3)}[file]
    path = written(folder, force / scale, force / scale, says)
    with pytest.raises(
        InputError, match=rf"wheel_1 is .* on average, .* it looks as if the file were in {file}: give --unit"
    ):
        read_measurement(path)
    found = read_measurement(path, Reading(units=(file,)))
    np.testing.assert_allclose(found.signals["wheel_1"], force, rtol=1e-8)


@given(static=LOADS, seed=SEEDS)
def test_tension_that_is_positive_is_recognised_and_given(folder: Path, static: float, seed: int) -> None:
    """F7: it made an axle without stress."""
    force = load(static, seed)
    path = written(folder, -force / 1e3, -force / 1e3)
    with pytest.raises(
        InputError, match=r"wheel_1 is -.* it looks as if tension is positive in it: give --sign tension"
    ):
        read_measurement(path)
    found = read_measurement(path, Reading(positive="tension"))
    np.testing.assert_allclose(found.signals["wheel_2"], force, rtol=1e-8)


@given(static=LOADS, seed=SEEDS, left=st.floats(-0.02, 0.02))
def test_a_missing_static_load_is_recognised_and_given(folder: Path, static: float, seed: int, left: float) -> None:
    force = load(static, seed)
    path = written(folder, (force - force.mean() + left * static) / 1e3, force / 1e3)
    with pytest.raises(
        InputError, match=r"wheel_1 is .* its static load is missing, as behind an AC-coupled amplifier"
    ):
        read_measurement(path)
    offset = force.mean() - left * static
    found = read_measurement(path, Reading(offsets={"wheel_1": offset}))
    np.testing.assert_allclose(found.signals["wheel_1"], force, rtol=1e-6)
    np.testing.assert_allclose(found.signals["wheel_2"], force, rtol=1e-8)


@given(static=LOADS, seed=SEEDS)
def test_a_constant_channel_is_warned_of(folder: Path, static: float, seed: int) -> None:
    path = written(folder, load(static, seed) / 1e3, np.full(400, static / 1e3))
    with pytest.warns(InputWarning, match=r"wheel_2 is constant at .* kN in 400 samples, .*: check the channel"):
        read_measurement(path)


def test_a_dead_channel_is_refused(folder: Path) -> None:
    path = written(folder, load(98e3, 1) / 1e3, np.zeros(400))
    with (
        pytest.raises(InputError, match=r"wheel_2 is 0 kN on average, .* the channel is dead"),
        pytest.warns(InputWarning),
    ):
        read_measurement(path)


@given(static=st.floats(1.0, 1e9), seed=SEEDS)
def test_a_load_of_no_wheel_needs_its_unit(folder: Path, static: float, seed: int) -> None:
    """A unit that is given is used, with a warning: a model wheel on a rig may have any load."""
    path = written(folder, load(static, seed), load(static, seed), "N")
    mean = float(load(static, seed).mean())
    told = (
        nullcontext()
        if 5e3 <= mean <= 300e3
        else pytest.warns(InputWarning, match="check the unit that you gave by --unit")
    )
    with told:
        read_measurement(path, Reading(units=("N",)))
    if not 5e3 <= mean <= 300e3:
        with pytest.raises(InputError, match=r"and wheels carry 5 to 300 kN: (it looks as if|give its unit, --unit)"):
            read_measurement(path)


def test_a_rail_that_pulls_is_warned_of(folder: Path) -> None:
    path = written(folder, load(98e3, 1) / 1e3 - 110.0 * (np.arange(400) > 380), load(98e3, 2) / 1e3)
    with pytest.warns(InputWarning, match="wheel_1 .* a rail does not pull a wheel down: check the zero"):
        read_measurement(path)


@pytest.mark.parametrize(
    ("scale", "words"),
    [(1e6, "is up to .* MPa, more than steel withstands"), (1e-6, "is up to 65 Pa, and axle stresses")],
)
def test_stresses_of_no_axle_are_named(folder: Path, scale: float, words: str) -> None:
    path = folder / "stress.csv"
    stress = 65.0 * scale * np.cos(np.arange(100) / 9.0)
    np.savetxt(
        path, np.column_stack([np.arange(100) * 1e-4, stress]), "%.9g", ",", header="time [s],A1 [MPa]", comments=""
    )
    with pytest.raises(InputError, match=words) if scale > 1 else pytest.warns(InputWarning, match=words):
        read_measurement(path)
    unit = "Pa" if scale > 1 else "MPa"
    if scale > 1:
        np.testing.assert_allclose(read_measurement(path, Reading(units=(unit,))).signals["A1"], stress, rtol=1e-8)
