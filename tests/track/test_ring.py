from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.runtime.cache import store
from wheelset_track_sim.track.ring import TrackRing, track_ring
from wheelset_track_sim.track.track import HALVES, load_track

TRACK = load_track("ballasted_60e1")


@pytest.fixture(scope="module", autouse=True)
def models(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("models")
        patch.setenv("WHEELSET_TRACK_SIM_CACHE", str(folder))
        yield folder


def small(**changes: float) -> TrackRing:
    return track_ring(TRACK, 0.01, **{"bays": 20, "max_frequency": 1000.0, **changes})


def test_tables_are_contiguous_rows_over_one_bay() -> None:
    ring = small()
    for name in HALVES:
        half = getattr(ring, name)
        modes = half.poles.size
        assert half.wavenumbers.shape == (modes,)
        for table in (half.input, half.output):
            assert table.shape == (60, modes)
            assert table.flags.c_contiguous
            assert table.dtype == np.complex128
        assert half.residual.shape == (60,)
        assert np.all(half.poles.real < 0.0)
        assert np.all(half.poles.imag >= 0.0)
        assert np.all(half.residual > 0.0)
        assert np.abs(half.wavenumbers).max() <= np.pi / 0.6 * (1 + 1e-12)


def test_a_cached_ring_is_the_built_one(models: Path) -> None:
    told: list[tuple[str, float]] = []
    built = small(max_frequency=1100.0, progress=lambda what, fraction: told.append((what, fraction)))
    fractions = [fraction for _, fraction in told]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    before = len(told)
    again = small(max_frequency=1100.0, progress=lambda what, fraction: told.append((what, fraction)))
    assert len(told) == before
    for name, array in built.to_arrays().items():
        np.testing.assert_array_equal(array, again.to_arrays()[name])


def test_tables_that_do_not_fit_together_are_not_a_ring(tmp_path: Path) -> None:
    arrays = small().to_arrays()
    store(tmp_path / "ring.npz", small())
    with np.load(tmp_path / "ring.npz") as stored:
        assert TrackRing.from_arrays(dict(stored)).bays == 20
    with pytest.raises(ValueError, match="tables"):
        TrackRing.from_arrays({**arrays, "symmetric_input": arrays["symmetric_input"][:, 1:]})
    with pytest.raises(KeyError):
        TrackRing.from_arrays({key: value for key, value in arrays.items() if key != "symmetric_poles"})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"dx": 0.007}, "dx = 0.007 m does not divide.*0.6 m"),
        ({"dx": 0.0}, "dx = 0 m"),
        ({"dx": float("nan")}, "dx = nan"),
        ({"bays": 3}, "bays = 3.*10 to 1000"),
        ({"max_frequency": 9e4}, "max_frequency = 90000 Hz"),
        ({"tolerance": -1.0}, "tolerance = -1"),
    ],
)
def test_what_makes_no_ring_is_refused(change: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        track_ring(TRACK, **{"dx": 0.01, "bays": 20, **change})
