import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.monitoring.limits import IN_ORDER, Limits


def test_the_defaults_are_limits_in_use():
    assert Limits().force_error == 350e3
    assert (Limits().stress_warn, Limits().stress_error) == (166e6, 200e6)


@pytest.mark.parametrize(("lower", "upper"), IN_ORDER)
def test_a_warning_behind_its_alarm_is_refused(lower, upper):
    values = {lower: getattr(Limits(), upper) * 1.01, upper: getattr(Limits(), upper) * 1.0}
    if lower == "pace_error":
        values = {"pace_error": 0.6, "pace_warn": 0.5}
    with pytest.raises(InputError, match=f"{lower} = .* is above {upper} = .*: give"):
        Limits(**values)


def test_what_is_out_of_range_is_refused():
    with pytest.raises(InputError, match="force_error = nan is not finite"):
        Limits(force_error=float("nan"))
    with pytest.raises(InputError, match=r"pace_warn = 1\.1 is out of range"):
        Limits(pace_warn=1.1)
