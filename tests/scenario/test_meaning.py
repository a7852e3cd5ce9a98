"""What keys of a scenario mean."""

import pytest

from wheelset_track_sim.scenario.meaning import meaning_of


@pytest.mark.parametrize(
    ("key", "meaning"),
    [
        ("irregularities.0.h", ("depth", "m")),
        ("track.sleeper.length", None),
        ("events.0.axle_load", ("static load on both wheels together", "N")),
        ("events.1.add.0.h", ("depth", "m")),
        ("max_frequency", ("band limit", "Hz")),
        ("lag_zero", ("lag_zero", "")),
        ("nothing.at.all", ("nothing.at.all", "")),
    ],
)
def test_meaning_of_keys_comes_from_their_declaration(key: str, meaning: tuple[str, str] | None) -> None:
    found = meaning_of(key)
    assert found == meaning or (meaning is None and found[1] == "m")
