import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.simulation.pacing import Pace, Pacer


class Clock:
    def __init__(self):
        self.now = 17.0

    def __call__(self):
        return self.now


def test_sample_is_due_when_its_time_at_the_factor_has_passed():
    clock = Clock()
    pacer = Pacer(4.0, simulated=10.0, clock=clock)
    assert pacer.wait(12.0) == pytest.approx(0.5)
    clock.now += 0.75
    assert pacer.wait(12.0) == pytest.approx(-0.25)
    assert pacer.wait(13.0) == pytest.approx(0.0)


def test_factor_zero_never_waits():
    clock = Clock()
    pacer = Pacer(0.0, 0.0, clock)
    clock.now += 100
    assert pacer.wait(1e6) == 0.0


@given(
    chunk=st.floats(0.001, 1.0),
    period=st.floats(2e-6, 4e-4),
    duration=st.floats(0.001, 20.0),
)
def test_chunks_add_up_to_the_duration(chunk, period, duration):
    pace = Pace(chunk_duration=chunk, duration=duration)
    whole = round(duration / period)
    done = 0
    for _ in range(whole + 1):
        steps = pace.steps(done * period, period)
        if steps == 0:
            break
        assert steps <= max(1, round(chunk / period))
        done += steps
        if done < whole // 2:  # the first half need not be walked
            done = whole // 2
    assert done == whole


def test_endless_run_has_whole_chunks_for_ever():
    assert Pace().steps(1e9, 36e-6) == round(0.05 / 36e-6)


@pytest.mark.parametrize("field", ["chunk_duration", "real_time_factor", "duration"])
def test_refusals_name_the_field(field):
    with pytest.raises(InputError, match=f"^{field} = -1 .*is out of range"):
        Pace(**{field: -1.0})
