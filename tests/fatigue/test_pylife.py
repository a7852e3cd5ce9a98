"""The rainflow count and the mean stress against pylife, an independent package, where it is installed."""

import numpy as np
import pytest

from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow import Rainflow
from wheelset_track_sim.fatigue.rainflow_kernels import equivalent_amplitude
from wheelset_track_sim.fatigue.scatter import ScatteredDamage

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


def test_failure_probability_and_limits_of_other_survival():
    failure = pytest.importorskip("pylife.strength.failure_probability", reason="pylife is not installed")
    curves = pytest.importorskip("pylife.materiallaws.woehlercurve", reason="pylife is not installed")
    count = Rainflow(1, CURVE)
    count.push(90e6 * np.cos(2 * np.pi * np.arange(10_001) / 200)[np.newaxis])
    axle = ScatteredDamage(count.spectrum, 0, CURVE, distance=100.0)
    own = {"SD": CURVE.limit, "ND": CURVE.knee_cycles, "k_1": CURVE.slope, "TS": CURVE.amplitude_scatter}
    median = curves.WoehlerCurve.from_parameters(**own, failure_probability=1 - CURVE.survival_probability)
    strength = failure.FailureProbability(1.0, axle.deviation)
    for distance in (1e7, 3e8):
        load = axle.damage("elementary", distance) ** (1 / CURVE.slope)
        expected = strength.pf_simple_load(load)
        assert axle.failure_probability("elementary", distance) == pytest.approx(float(expected), rel=1e-6)
    for end, share in zip(axle.band("elementary", 1e6), (0.025, 0.975), strict=True):
        limit = float(median.transform_to_failure_probability(share).SD)
        assert end == pytest.approx(axle.damage("elementary", 1e6, limit / CURVE.limit), rel=1e-6)
