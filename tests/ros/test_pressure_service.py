"""The contact pressure by service."""

import math

import numpy as np
import pytest

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


PAUSED = 1


def assert_equilibrium(found):
    pressure = np.reshape(found.pressure, (found.rows, found.columns))
    assert (pressure >= 0).all()
    assert pressure.sum() * found.dx * found.dy == pytest.approx(found.force, rel=1e-9)
    inside = np.argwhere(pressure > 0)
    x, y = found.x0 + inside[:, 0] * found.dx, found.y0 + inside[:, 1] * found.dy
    assert np.abs(x).max() < 0.03
    assert np.abs(y).max() < 0.03


def test_pressure_now_and_at_the_worst_impact(start, client, services, forces, states):
    summaries = client.collect("summary", "LoadSummary")
    start(scenario="damage_wheel_1")
    client.until(lambda: forces and sum(len(chunk.wheel_1) for chunk in forces) > 2 * 2713)
    assert services.trigger("pause").success  # so that the latest step is the last that arrived
    client.until(lambda: states and states[-1].status == PAUSED)
    client.until(lambda: summaries[-1].first_step + summaries[-1].samples == states[-1].first_step)
    steps = np.concatenate([chunk.first_step + np.arange(len(chunk.wheel_1)) for chunk in forces])
    of_wheel = {wheel: np.concatenate([getattr(chunk, f"wheel_{wheel}") for chunk in forces]) for wheel in (1, 2)}
    for wheel in (1, 2):
        latest = services.pressure(wheel, 0)
        assert latest.success, latest.message
        assert latest.step == states[-1].first_step - 1 == steps[-1]
        assert latest.force == pytest.approx(of_wheel[wheel][-1], rel=1e-6)
        assert_equilibrium(latest)
        worst = services.pressure(wheel, 1)
        assert_equilibrium(worst)
        assert worst.force >= of_wheel[wheel].max() * (1 - 1e-6)
        if worst.step >= steps[0]:
            assert worst.step == steps[of_wheel[wheel].argmax()]
    impact = services.pressure(1, 1)
    assert impact.force > 2.5 * 98.1e3
    assert min(impact.angle, 2 * math.pi - impact.angle) * 0.43175 < 0.060  # the damage is at angle 0
    assert impact.position == pytest.approx(impact.step * 1e-3, rel=1e-12)
    assert impact.time == pytest.approx(impact.position / impact.speed, rel=1e-9)
    assert (impact.header.frame_id, impact.revision) == ("track", 0)
    assert services.damage().success
    assert services.trigger("resume").success
    client.until(lambda: forces[-1].revision == 1)
    again = services.pressure(1, 1)  # of the treads that were, in a run that has gone on
    assert (again.step, again.pressure) == (impact.step, impact.pressure)
    assert services.pressure(1, 0).step > impact.step
    assert "wheel = 3 is not a wheel" in services.pressure(3).message
    assert "at = 2 is not known" in services.pressure(1, 2).message
    assert services.trigger("reset").success
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 1)
    assert services.pressure(1, 1).force < 1.2 * 98.1e3  # since the start of this run
