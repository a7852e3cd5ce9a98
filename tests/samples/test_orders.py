"""Orders and averages over turns of the wheel."""

import numpy as np
import pytest

from wheelset_track_sim import InputError
from wheelset_track_sim.samples.orders import averaged, orders, over_angle

AROUND = 2.713


def positions(turns=24.3, *, accelerating=False):
    """Positions of samples evenly spaced in time, at a speed that may rise by half."""
    time = np.linspace(0.0, 1.0, 40_000)
    return turns * AROUND * ((time + 0.25 * time**2) / 1.25 if accelerating else time) + 0.4


@pytest.mark.parametrize("accelerating", [False, True])
def test_waves_around_the_wheel_are_orders_at_any_speed(accelerating):
    x = positions(accelerating=accelerating)
    turned = 2 * np.pi * (x - 1.8) / AROUND
    signal = 5.0 + 3.0 * np.sin(turned) + 0.2 * np.cos(17 * turned + 1.0)
    found = orders(over_angle(signal, x, AROUND, 1.8, per_turn=512))
    assert np.sqrt(found.mean_square[[0, 1, 17]]) == pytest.approx([5.0, 3 / np.sqrt(2), 0.2 / np.sqrt(2)], rel=2e-3)
    others = np.delete(found.mean_square, [0, 1, 17])
    assert others.sum() < 1e-4 * found.mean_square[17]


def test_the_energy_of_orders_is_the_mean_square():
    x = positions()
    of = over_angle(np.random.default_rng(2).standard_normal(len(x)).cumsum(), x, AROUND, per_turn=512)
    assert orders(of).mean_square.sum() == pytest.approx((of.turns**2).mean(), rel=1e-12)


def test_the_mean_turn_keeps_what_belongs_to_the_wheel():
    x = positions(turns=60.2)
    wheel = np.exp(-(((x - 1.8) / AROUND % 1.0 - 0.25) ** 2) / 2e-4)
    sleepers = np.cos(2 * np.pi * x / 0.6)
    of = over_angle(wheel + sleepers, x, AROUND, 1.8, per_turn=512)
    mean = averaged(of)
    assert mean.turns == len(of.turns) == 59
    assert of.angles[mean.mean.argmax()] == pytest.approx(np.pi / 2, abs=0.02)
    assert mean.mean.max() == pytest.approx(1.0, abs=0.3)
    assert mean.rest.mean() == pytest.approx(1 / np.sqrt(2), rel=0.05)


def test_less_than_a_turn_is_refused():
    with pytest.raises(InputError, match=r"without a whole turn of the wheel of 2.713 m"):
        over_angle(np.zeros(1000), np.linspace(0.0, 2.0, 1000), AROUND)
