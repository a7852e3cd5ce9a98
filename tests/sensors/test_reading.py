"""What sensors give: sampling, noise, range, and the same bits however a run is cut."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.sensors.kinds import AxleBoxAcceleration, StrainGauge
from wheelset_track_sim.sensors.noise import Numbers, Walk
from wheelset_track_sim.sensors.reading import SensorReader, SensorReaders, peaks

RATE, STEPS = 5000.0, 25_000.0  # Hz
BOXES = AxleBoxAcceleration(rate=RATE)


def block(first, count, signal, period=1 / STEPS, time=None, topic="axle_box_acceleration"):
    """A block whose sensor has the value ``signal(t)`` on both channels."""
    start = first * period if time is None else time
    values = signal(start + period * np.arange(count))
    of = SampleBlock(
        first, start, period, 1e-3 / period, first * 1e-3, 0, np.zeros((count, 2)), np.zeros((count, 0, 6)), ()
    )
    return replace(of, sensors={topic: np.stack([values, -values], axis=1)})


def read(sensor, blocks, **options):
    reader = SensorReader(sensor, 1000, 0, **options)
    chunks = [chunk for each in blocks for chunk in reader.push(each, sensor)]
    return chunks + reader.finish()


def joined(chunks, name="wheel_1"):
    return np.concatenate([chunk.values[name] for chunk in chunks])


@pytest.mark.parametrize(("frequency", "gain"), [(200.0, 1.0), (1900.0, 1.0), (2800.0, 0.0), (7200.0, 0.0)])
def test_waves_pass_up_to_four_fifths_of_half_the_rate_and_none_is_aliased(frequency, gain):
    wave = lambda t: np.sin(2 * np.pi * frequency * t)  # noqa: E731
    (chunk, *rest) = read(BOXES, [block(0, 20_000, wave)])
    found = joined([chunk, *rest])
    times = np.arange(len(found)) / RATE
    inside = slice(60, -60)
    assert found[inside] == pytest.approx(gain * wave(times)[inside], abs=1e-3)
    assert (chunk.first_sample, chunk.time, chunk.step_period) == (0, 0.0, 1 / RATE)


def test_samples_keep_their_times_when_the_speed_changes():
    wave = lambda t: np.sin(2 * np.pi * 300.0 * t)  # noqa: E731
    slow = 1 / 17_321.0
    blocks = [block(0, 7000, wave), block(7000, 6000, wave, slow, time=7000 / STEPS)]
    chunks = read(BOXES, blocks)
    found = joined(chunks)
    assert [chunk.first_sample for chunk in chunks] == [0, *np.cumsum([len(chunk) for chunk in chunks])[:-1]]
    assert found[60:-60] == pytest.approx(wave(np.arange(len(found)) / RATE)[60:-60], abs=5e-3)


def test_samples_have_the_same_bits_however_the_run_is_cut():
    noisy = AxleBoxAcceleration(rate=RATE, noise=0.3, drift=1.0, range=1.2, seed=7)
    wave = lambda t: np.sin(2 * np.pi * 331.0 * t) + 0.3 * t  # noqa: E731
    whole = joined(read(noisy, [block(0, 12_000, wave)]))
    cuts = [0, 1, 700, 5000, 5001, 12_000]
    values = block(0, 12_000, wave).sensors["axle_box_acceleration"]
    parts = [replace(block(a, b - a, wave), sensors={"axle_box_acceleration": values[a:b]}) for a, b in pairwise(cuts)]
    assert (joined(read(noisy, parts)) == whole).all()
    assert np.abs(whole).max() == 1.2
    other = joined(read(replace(noisy, seed=8), [block(0, 12_000, wave)]))
    assert (other != whole).mean() > 0.5


def test_noise_changes_at_a_step_and_has_the_same_bits_however_the_run_is_cut():
    sensor = AxleBoxAcceleration(rate=RATE, noise=0.1, drift=0.2)
    flat = lambda t: 0.0 * t  # noqa: E731

    def given(*cuts):
        reader = SensorReader(sensor, 1000, 0)
        changed = {True: replace(sensor, noise=0.0, drift=0.4), False: sensor}
        chunks = [chunk for a, b in pairwise(cuts) for chunk in reader.push(block(a, b - a, flat), changed[a >= 6000])]
        return joined(chunks + reader.finish())

    whole = given(0, 6000, 12_000)
    assert (given(0, 1, 5999, 6000, 6001, 9000, 12_000) == whole).all()
    at = int(np.ceil(6000 / STEPS * RATE))
    first, rest = (joined(read(replace(sensor, **one), [block(0, 12_000, flat)])) for one in ({}, {"noise": 0.0}))
    assert (whole[:at] == first[:at]).all()
    assert (whole[at:] == 2 * rest[at:]).all()


def test_noise_has_its_size_and_a_drift_grows():
    flat = lambda t: 0.0 * t  # noqa: E731
    white = joined(read(AxleBoxAcceleration(rate=RATE, noise=0.5), [block(0, 60_000, flat)]))
    assert white.std() == pytest.approx(0.5, rel=0.03)
    walk = Walk("a", 400).between(0, 1000)
    assert walk[-1].std() == pytest.approx(np.sqrt(1000), rel=0.1)
    assert (Walk("a", 400).between(700, 1000) == walk[700:]).all()
    assert (Numbers("b", 1).between(4090, 4110) == Numbers("b", 1).between(0, 5000)[4090:4110]).all()


def test_without_a_rate_and_a_range_a_sensor_gives_the_true_values():
    given = block(40, 300, np.cos)
    (chunk,) = read(AxleBoxAcceleration(), [given])
    assert (chunk.values["wheel_2"] == given.sensors["axle_box_acceleration"][:, 1]).all()
    assert (chunk.first_sample, chunk.first_step) == (40, 40)
    sensors = [AxleBoxAcceleration(rate=RATE, true_value=True)]
    readers = SensorReaders(sensors, 1000, 0)
    assert [chunk.topic for chunk in readers.push(block(0, 2000, np.cos), sensors)] == [
        "axle_box_acceleration",
        "axle_box_acceleration/true",
    ]
    assert readers.channels == ("axle_box_acceleration/wheel_1", "axle_box_acceleration/wheel_2")


def test_a_gauge_tells_its_angle():
    gauge = StrainGauge(name="g", angle=0.5, rate=1000.0)
    turning = replace(block(0, 5000, np.cos), sensors={"strain/g": np.zeros((5000, 1))})
    chunks = read(gauge, [turning])
    times = np.arange(200) / 1000.0
    assert joined(chunks, "angle") == pytest.approx((0.5 + 2 * np.pi * times * STEPS / 1000) % (2 * np.pi), abs=1e-9)


def test_peaks_are_those_of_what_came():
    (chunk,) = read(AxleBoxAcceleration(), [block(0, 25_000, lambda t: 3 * np.sin(2 * np.pi * 10 * t))])
    peak, rms = peaks(("axle_box_acceleration/wheel_1", "strain/g/strain"), [chunk])
    assert peak == pytest.approx([3.0, np.nan], nan_ok=True, rel=1e-4)
    assert rms == pytest.approx([3 / np.sqrt(2), np.nan], nan_ok=True, rel=1e-6)


def test_what_a_run_gives_is_what_its_blocks_give():
    sensors = [{"type": "axle_box_acceleration", "rate": 8000.0, "noise": 0.1, "range": 300.0}]
    one, other = (toy_simulator(like="damage_wheel_1", sensors=sensors) for _ in range(2))
    readers = [SensorReaders(one.scenario.sensors, one.steps_per_revolution, 0) for _ in range(2)]
    own = one.scenario.sensors
    whole = readers[0].push(one.advance(6000), own) + readers[0].finish()
    parts = [chunk for count in (999, 1, 3000, 2000) for chunk in readers[1].push(other.advance(count), own)]
    parts += readers[1].finish()
    assert (joined(whole) == joined(parts)).all()
