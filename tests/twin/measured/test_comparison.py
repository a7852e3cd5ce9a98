"""Synthetic measurements: a simulation, resampled, moved, with noise and gain, is found again."""

import json
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.paths import ROOT
from wheelset_track_sim.bags import blocks as recorded
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.resampling import band_limited
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin.measured import Matching, Measurement, compare
from wheelset_track_sim.twin.measured.reading import read_measurement

EXAMPLE = ROOT / "config" / "measured" / "synthetic_wayside.csv"
TURN = 2713


@pytest.fixture(scope="module")
def blocks() -> list[SampleBlock]:
    """Less than a turn and a half, so that nothing repeats."""
    simulator = Simulator(load_scenario("damage_wheel_1"))
    return [simulator.advance(1300) for _ in range(3)]


def synthetic(
    blocks: list[SampleBlock],
    rate: float,
    lag: float,
    gain: float = 1.0,
    noise: float = 0.0,
    axis: str = "time",
    seed: int = 0,
) -> Measurement:
    """One turn of the wheel and a little more, sampled at ``rate`` as measuring amplifiers do it."""
    forces = np.concatenate([block.forces for block in blocks])
    stress = np.concatenate([block.stresses for block in blocks])[:, 0, 1:2]
    step = blocks[0].step_period if axis == "time" else 1e-3
    at = np.arange(300 * step, 3700 * step, 1 / rate)
    found = band_limited(np.concatenate([forces, stress], axis=1), at / step, 1 / rate / step)
    chance = np.random.default_rng(seed)
    found = found * gain + noise * found.std(axis=0) * chance.standard_normal(found.shape)
    names = ("wheel_1", "wheel_2", "A1_yy")
    return Measurement(Path("synthetic"), axis, at - lag, dict(zip(names, found.T, strict=True)))  # type: ignore[arg-type]


@pytest.mark.slow
@settings(max_examples=20)
@given(
    rate=st.floats(2e3, 5e4),
    lag=st.floats(-1e3, 1e3),
    gain=st.floats(0.5, 2.0),
    noise=st.floats(0.0, 0.2),
    seed=st.integers(0, 2**32 - 1),
)
def test_lag_and_gain_are_found_again(
    blocks: list[SampleBlock], rate: float, lag: float, gain: float, noise: float, seed: int
) -> None:
    found = compare(blocks, synthetic(blocks, rate, lag, gain, noise, seed=seed))
    assert abs(found.lag - lag) < 6 * found.uncertainty + 1e-3 * found.step + 1e-12 * abs(lag)
    assert found.uncertainty < 0.2 * found.step
    for each in found.agreement:
        assert each.gain == pytest.approx(gain, rel=0.01 + 0.4 * noise)  # six standard deviations
        assert each.correlation > 0.997 - 0.7 * noise


def test_a_perfect_measurement_has_no_error(blocks: list[SampleBlock]) -> None:
    found = compare(blocks, synthetic(blocks, 1e4, 0.123456))
    assert found.lag == pytest.approx(0.123456, abs=1e-8)
    assert found.agreement[0].rms_error < 100.0  # of 98 kN: what two filters in a row leave of an impact
    assert found.agreement[2].correlation > 0.99999
    [pair] = found.impacts
    assert pair.signal == "wheel_1"
    assert abs(pair.error) < 1e-3
    assert found.at[0] == pytest.approx(300 * blocks[0].step_period, abs=2e-4)


def test_positions_are_an_axis_too(blocks: list[SampleBlock]) -> None:
    found = compare(blocks, synthetic(blocks, 400.0, 12.34, axis="position"))
    assert found.unit == "m"
    assert found.lag == pytest.approx(12.34, abs=1e-5)
    assert found.impacts[0].at == pytest.approx(1.81, abs=0.01)


def test_a_train_that_brakes_is_compared_over_time() -> None:
    """Its steps grow to four times their duration, and none of them is a gap."""
    chance = np.random.default_rng(5)
    made: list[SampleBlock] = []
    time = 0.0
    for number, speed in enumerate([40.0] * 6 + [30.0, 20.0, 15.0, 12.0, 10.0, 9.0]):
        forces = 98e3 + 1e3 * chance.standard_normal((1000, 2)).cumsum(axis=0)
        first, period = 1000 * number, 1e-3 / speed
        stresses = np.zeros((1000, 0, 6))
        made.append(SampleBlock(first, time, period, speed, 1e-3 * first, 0, forces, stresses, ()))
        time += 1000 * period
    at = np.concatenate([block.time + np.arange(1000) * block.step_period for block in made])
    force = np.concatenate([block.forces[:, 0] for block in made])
    sampled = np.arange(0.01, time - 0.01, 1e-3)
    measured = Measurement(Path("braking"), "time", sampled - 7.0, {"wheel_1": np.interp(sampled, at, force)})
    found = compare(made, measured)
    assert found.lag == pytest.approx(7.0, abs=0.5e-3)  # half a sample
    with pytest.raises(InputError, match="the simulation has a gap: step 2000 follows step 999"):
        compare([made[0], made[2]], measured)


@pytest.mark.slow
def test_what_repeats_is_ambiguous_unless_the_lag_is_given_about(blocks: list[SampleBlock]) -> None:
    smooth = Simulator(load_scenario("undamaged"))
    ripple = [smooth.advance(12 * 600)]  # sleepers alone
    at = np.arange(3000) * ripple[0].step_period
    again = Measurement(Path("ripple"), "time", at, {"wheel_1": ripple[0].forces[1800:4800, 0]})
    with pytest.raises(InputError, match=r"the lag is ambiguous: 0\.\d+ s and 0\.\d+ s give a correlation of 1\.000"):
        compare(ripple, again)
    found = compare(ripple, again, Matching(lag=0.065, reach=0.01))
    assert found.lag == pytest.approx(1800 * ripple[0].step_period, abs=1e-7)


@given(
    start=st.decimals(1_000_000_000, 4_000_000_000, places=6, allow_nan=False),
    unit=st.sampled_from(["s", "ms", "us", "ns", "iso"]),
    how=st.sampled_from(["", "lag", "origin"]),
)
@settings(max_examples=15)
@pytest.mark.slow
def test_time_stamps_are_compared_by_their_origin(
    blocks: list[SampleBlock], tmp_path_factory: pytest.TempPathFactory, start: Decimal, unit: str, how: str
) -> None:
    """F6: seconds since 1970 ended with a lag that could not be given."""
    of = synthetic(blocks, 1e4, 0.0)
    path = tmp_path_factory.getbasetemp() / "stamped.csv"
    places = [start + Decimal(f"{at:.7f}") for at in of.at]
    if unit == "iso":
        stamps = [f"{np.datetime64(int(at), 's')}.{int(at % 1 * 10**7):07d}Z" for at in places]
    else:
        stamps = [f"{at * 10 ** {'s': 0, 'ms': 3, 'us': 6, 'ns': 9}[unit]:f}" for at in places]
    heading = "time,wheel_1 [N]" if unit == "iso" else f"time [{unit}],wheel_1 [N]"
    path.write_text("\n".join([heading, *map("{},{:.3f}".format, stamps, of.signals["wheel_1"])]))
    given = {"lag": {"lag": -float(start)}, "origin": {"origin": float(start)}, "": {}}[how]
    found = compare(blocks, read_measurement(path), Matching(**given))
    assert float(found.begin - start) == pytest.approx(0.0, abs=1e-6)
    assert found.lag == pytest.approx(-float(start), abs=1e-6)
    assert found.begin_utc is not None
    assert found.begin_utc.startswith(str(np.datetime64(int(found.begin), "s")))
    with pytest.raises(InputError, match="no lag from"):
        compare(blocks, read_measurement(path), Matching(lag=-float(start) + 3.0))


def test_a_gain_of_another_unit_is_warned_of(blocks: list[SampleBlock]) -> None:
    of = synthetic(blocks, 1e4, 0.0)
    other = Measurement(of.source, of.axis, of.at, {"wheel_1": 729.0 * of.signals["wheel_1"]})
    with pytest.warns(InputWarning, match="gain of wheel_1 is 729, measured over simulated"):
        compare(blocks, other)


def test_what_cannot_be_compared_is_refused(blocks: list[SampleBlock]) -> None:
    at = np.arange(500) * 1e-4
    noise = np.random.default_rng(2).standard_normal(500)
    with pytest.raises(InputError, match=r"'Z9' is not a known signal of the simulation"):
        compare(blocks, Measurement(Path("a"), "time", at, {"Z9": noise}))
    with pytest.raises(InputError, match="no lag fits"):
        compare(blocks, Measurement(Path("a"), "time", at, {"wheel_1": noise}))
    with pytest.raises(InputError, match=r"no lag from 49.98.* s to 50.02.* s"):
        compare(blocks, synthetic(blocks, 1e4, 0.0), Matching(lag=50.0))
    with pytest.raises(InputError, match="reach = -1"):
        Matching(reach=-1)
    with pytest.raises(InputError, match="lag = nan is not finite"):
        Matching(lag=float("nan"))
    with pytest.raises(InputError, match="lag = 1 and origin = 2 exclude each other"):
        Matching(lag=1.0, origin=2.0)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    simulator = Simulator(load_scenario("damage_wheel_1"))
    path = tmp_path_factory.mktemp("bag") / "run.mcap"
    with record(path, simulator) as push:
        for _ in range(3):
            block = simulator.advance(TURN)
            push(block, summarise(block))
    return path


def test_the_shipped_example_is_what_it_says(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", str(bag), str(EXAMPLE), "--lag", "0.04", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["lag_s"] == pytest.approx(0.0371234, abs=1e-4)
    assert found["correlation"] > 0.9
    wheel = found["signals"]["wheel_1"]
    assert wheel["max_simulated"] > wheel["max_measured"]  # the defect of the example is less deep
    assert wheel["mean_error"] == pytest.approx(-0.02 * 98.1e3, rel=0.1)
    assert found["impacts"][0]["wheel"] == "wheel_1"


def test_tables_are_for_people(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", str(bag), str(EXAMPLE), "--lag", "0.04", "--threshold", "150e3"]) == 0
    text = capsys.readouterr().out
    for word in ("max, measured", "kN", "MPa", "Sprague", "impacts", "standard deviation"):
        assert word in text
    assert main(["compare", str(bag), str(EXAMPLE.with_name("none.csv"))]) == 2


@pytest.mark.slow
def test_a_bag_is_a_measurement_too(bag: Path, blocks: list[SampleBlock]) -> None:
    measured = read_measurement(bag)
    assert {"wheel_1", "wheel_2", "A1", "A1_yy"} <= measured.signals.keys()
    found = compare(blocks, measured)
    assert found.lag == pytest.approx(0.0, abs=1e-8)
    assert max(abs(each.mean_error) for each in found.agreement) < 1e-3 * 98.1e3


def test_a_part_of_a_long_bag_is_enough(bag: Path, blocks: list[SampleBlock]) -> None:
    step = blocks[0].step_period
    found = compare(recorded(bag, start=0.02, stop=0.15), synthetic(blocks, 1e4, 5.0), Matching(lag=5.0))
    assert found.lag == pytest.approx(5.0, abs=1e-7)
    assert found.at[0] == pytest.approx(300 * step, abs=2e-4)
