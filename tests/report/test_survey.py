"""One pass keeps what the report shows: every peak, whatever the length of the run and of its blocks."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from wheelset_track_sim.report.envelope import Bins, Envelope, drawn
from wheelset_track_sim.report.samples import Closeups, SampleSeries
from wheelset_track_sim.report.spectrum import Welch

RNG = np.random.default_rng(5)


def samples(first: int, count: int, columns: int = 3) -> SampleSeries:
    time = (first + np.arange(count)) * 1e-4
    return SampleSeries(first, time, 10 * time, RNG.normal(size=(count, columns)))


def cut(whole: SampleSeries, lengths):
    first = whole.first_step
    while first < whole.end:
        length = min(next(lengths), whole.end - first)
        yield whole.between(first, first + length)
        first += length


def of_lengths(largest):
    rng = np.random.default_rng(largest)
    while True:
        yield int(rng.integers(1, largest + 1))


@pytest.mark.parametrize("largest", [1, 7, 1000])
@pytest.mark.parametrize("count", [5, 64, 65, 1000, 4097])
def test_bins_hold_minimum_and_maximum_of_their_samples(count, largest):
    whole = samples(40, count)
    envelope = Envelope(capacity=64)
    for part in cut(whole, of_lengths(largest)):
        envelope.push(part)
    bins = envelope.bins()
    assert len(bins) <= 64 + 1
    assert len(bins) == -(-count // bins.size)
    assert bins.first_step == 40
    for number in range(len(bins)):
        part = slice(number * bins.size, (number + 1) * bins.size)
        assert bins.time[number] == whole.time[part][0]
        np.testing.assert_array_equal(bins.low[number], whole.values[part].min(axis=0))
        np.testing.assert_array_equal(bins.high[number], whole.values[part].max(axis=0))


def test_closeups_resolve_whole_bins():
    whole = samples(0, 100)
    parts = whole.values.reshape(10, 10, -1)
    bins = Bins(10, 0, whole.time[::10], parts.min(axis=1), parts.max(axis=1))
    found = drawn(bins, [whole.between(25, 55), whole.between(41, 60)])  # bins 3, 4 and 5
    fine = slice(3, 33)
    assert len(found.time) == 7 + 30
    np.testing.assert_array_equal(found.time[fine], whole.time[30:60])
    np.testing.assert_array_equal(found.low[fine], whole.values[30:60])
    np.testing.assert_array_equal(found.high[fine], whole.values[30:60])
    np.testing.assert_array_equal(found.high.max(axis=0), whole.values.max(axis=0))
    assert (np.diff(found.time) > 0).all()


@pytest.mark.parametrize("largest", [1, 13, 400])
def test_closeups_hold_every_sample_around_the_largest_peaks(largest):
    whole = samples(0, 2000)
    peaks = {300: 5.0, 310: 4.0, 900: 7.0, 1500: 6.0, 1990: 6.5}
    closeups = Closeups(before=20, after=50, late=400, number=3)
    for part in cut(whole, of_lengths(largest)):
        closeups.push(part)
        for step, force in peaks.items():
            if part.first_step <= step < part.end:
                closeups.peak(step, force)
    found = closeups.found()
    assert [(closeup.step, closeup.force) for closeup in found] == [(900, 7.0), (1990, 6.5), (1500, 6.0)]
    for closeup in found:
        expected = whole.between(closeup.step - 20, closeup.step + 50)
        assert closeup.samples.first_step == closeup.step - 20
        np.testing.assert_array_equal(closeup.samples.values, expected.values)


def test_a_peak_told_late_still_has_its_closeup():
    whole = samples(0, 1000)
    closeups = Closeups(before=20, after=50, late=100)
    for part in cut(whole, of_lengths(30)):
        closeups.push(part)
        if part.first_step <= 500 < part.end:
            closeups.peak(440, 1.0)
            closeups.peak(100, 9.0)  # too long ago
    assert [closeup.step for closeup in closeups.found()] == [440]
    assert closeups.found()[0].samples.first_step == 420


@pytest.mark.parametrize("largest", [1, 300, 5000])
def test_the_spectrum_is_that_of_welch(largest):
    whole = samples(0, 4000)
    collected = Welch(segment=512)
    for part in cut(whole, of_lengths(largest)):
        collected.push(10.0, 1e-4, part.values)
    found = collected.spectrum()
    frequency, density = scipy.signal.welch(whole.values, 1e4, nperseg=512, axis=0)
    np.testing.assert_allclose(found.frequency, frequency, rtol=1e-12)
    np.testing.assert_allclose(found.density, density, rtol=1e-10)
    assert (found.segments, found.speed) == (14, 10.0)


def test_a_tone_has_its_power_at_its_frequency():
    time = np.arange(20_000) * 1e-4
    tone = 3.0 * np.sqrt(2) * np.sin(2 * np.pi * 1234.5 * time)[:, np.newaxis]
    collected = Welch(segment=2048)
    collected.push(10.0, 1e-4, tone)
    found = collected.spectrum()
    assert found.frequency[found.density[:, 0].argmax()] == pytest.approx(1234.5, abs=found.frequency[1])
    assert found.density[:, 0].sum() * found.frequency[1] == pytest.approx(9.0, rel=1e-3)
    assert found.frequency[-1] == pytest.approx(5000)


def test_spectra_at_other_speeds_stay_apart():
    collected = Welch(segment=512)
    slow, fast, again = (samples(0, count).values for count in (600, 2000, 1000))
    collected.push(10.0, 1e-4, slow)
    collected.push(20.0, 5e-5, fast)
    collected.push(10.0, 1e-4, again)
    found = collected.spectrum()
    assert found.speed == 20.0
    np.testing.assert_allclose(found.density, scipy.signal.welch(fast, 2e4, nperseg=512, axis=0)[1], rtol=1e-10)


def test_a_short_run_is_one_segment_and_a_shorter_one_has_no_spectrum():
    part = samples(0, 300)
    collected = Welch(segment=512)
    collected.push(10.0, 1e-4, part.values)
    np.testing.assert_allclose(
        collected.spectrum().density, scipy.signal.welch(part.values, 1e4, nperseg=300, axis=0)[1], rtol=1e-10
    )
    collected = Welch(segment=512)
    collected.push(10.0, 1e-4, part.values[:200])
    assert collected.spectrum() is None


@pytest.mark.parametrize("chunk", [97, 1389, 50_000])
def test_a_survey_does_not_depend_on_the_blocks(make_survey, chunk):
    spikes = [(1.8, 300e3), (4.513, 320e3), (30.0, 555e3), (30.5, 210e3)]
    one = make_survey("damage_wheel_1", length=40.0, spikes=spikes, chunk=5000)
    other = make_survey("damage_wheel_1", length=40.0, spikes=spikes, chunk=chunk)
    for found, expected in zip(other.impacts, one.impacts, strict=True):
        assert (found.time, found.position) == pytest.approx((expected.time, expected.position), rel=1e-12)
        assert replace(found, time=0.0, position=0.0) == replace(expected, time=0.0, position=0.0)
    assert [impact.peak_force for impact in other.impacts] == [300e3, 320e3, 555e3, 210e3]
    assert (other.peak.wheel, other.peak.step, other.peak.force) == (0, 30_000, 555e3)
    assert [closeup.step for closeup in other.closeups][:3] == [30_000, 4513, 1800]
    np.testing.assert_array_equal(other.bins.low, one.bins.low)
    np.testing.assert_array_equal(other.bins.high, one.bins.high)
    np.testing.assert_allclose(other.bins.time, one.bins.time, rtol=1e-12)
    assert other.bins.high[:, 0].max() == 555e3
    assert other.bins.low[:, 0].min() == 0.0
    assert other.duration == pytest.approx(40.001 / (100 / 3.6), rel=1e-6)


def test_impacts_tell_where_on_the_wheel(make_survey):
    turn = 2713 * 1e-3
    run = make_survey("damage_both", length=8.0, wheel=1, spikes=[(1.8, 250e3), (1.8 + turn, 260e3), (3.1565, 270e3)])
    angles = {impact.peak_force: np.degrees(impact.angle) for impact in run.impacts}
    assert angles[250e3] == pytest.approx(0.0, abs=1e-6)
    assert angles[260e3] == pytest.approx(0.0, abs=1e-6)
    assert angles[270e3] == pytest.approx(180.0, abs=0.2)
    assert {impact.wheel for impact in run.impacts} == {1}
    assert run.impacts[0].dynamic_factor == pytest.approx(250 / 98.1)


def test_the_static_force_of_an_impact_is_that_of_its_revision(make_survey):
    run = make_survey(length=6.0, spikes=[(1.0, 300e3), (5.0, 300e3)], revisions=[(3000, ["axle_load=150000"])])
    assert [impact.dynamic_factor for impact in run.impacts] == [pytest.approx(300 / 98.1), pytest.approx(4.0)]
    assert run.scenario_in_force(1).axle_load == 150e3


def test_impacts_above_a_threshold(make_survey):
    spikes = [(1.0, 210e3), (3.0, 310e3)]
    assert len(make_survey(spikes=spikes).impacts) == 2
    assert [impact.peak_force for impact in make_survey(spikes=spikes, threshold=300e3).impacts] == [310e3]
    assert make_survey(spikes=spikes, known=False).impacts == ()
