"""The rainflow count and the mean stress against pylife, an independent package, where it is installed."""

import numpy as np
import pytest

from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow import Rainflow
from wheelset_track_sim.fatigue.rainflow_kernels import equivalent_amplitude

rainflow = pytest.importorskip("pylife.stress.rainflow", reason="pylife is not installed: extra fatigue")
CURVE = load_curve("assumed_body")


def damage(ranges):
    return np.sum((ranges / 2 / CURVE.limit) ** CURVE.slope) / CURVE.knee_cycles


@pytest.mark.parametrize("seed", range(20))
def test_damage_of_random_channels(seed):
    random = np.random.default_rng(seed)
    turned = 2 * np.pi * np.arange(20_000) / 2713
    stress = 60e6 * np.cos(turned) + 10e6 * np.cumsum(random.normal(size=20_000)) / 50 + random.normal(0, 5e6, 20_000)
    count = Rainflow(1, CURVE, gate=0.0)
    count.push(stress[np.newaxis])
    recorder = rainflow.FullRecorder()
    detector = rainflow.FourPointDetector(recorder=recorder).process(stress)
    closed = np.abs(np.asarray(recorder.values_from) - np.asarray(recorder.values_to))
    residue = np.abs(np.diff(detector.residuals))
    assert count.spectrum.cycles[0] == len(closed) + len(residue) / 2
    assert count.spectrum.damage[0, 0] == pytest.approx(damage(closed) + damage(residue) / 2, rel=1e-6)


def test_mean_stress_is_that_of_the_fkm_guideline():
    meanstress = pytest.importorskip("pylife.strength.meanstress", reason="pylife is not installed: extra fatigue")
    amplitudes = np.array([100.0, 80.0, 60.0, 50.0, 30.0, 30.0])
    means = np.array([0.0, 50.0, -50.0, 100.0, 200.0, -90.0])
    found = [equivalent_amplitude(a, m, 0.3) for a, m in zip(amplitudes, means, strict=True)]
    expected = meanstress.fkm_goodman(amplitudes, means, M=0.3, M2=0.1, R_goal=-1)
    assert found == pytest.approx(np.ravel(expected).tolist(), rel=1e-9)
