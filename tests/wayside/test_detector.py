"""Detectors as people give them, and what is refused."""

import dataclasses

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.schema import plain, read
from wheelset_track_sim.track.supports import SupportLine
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wayside.detector import Detector, check_place, load_detector

TRACK = load_track("ballasted_60e1")
GAUGE = {"type": "shear_bridge", "name": "g", "on": "rail_1", "x": 0.3}


def made(*channels, **keys):
    return read(Detector, {"name": "mine", "channels": [*channels], **keys}, "")


@pytest.mark.parametrize("name", shipped.names("detectors"))
def test_a_shipped_detector_stands_on_every_shipped_track_and_reads_both_rails(name):
    detector = load_detector(name)
    assert detector.name == name
    assert {channel.on for channel in detector.channels} == {"rail_1", "rail_2"}
    assert read(Detector, plain(detector), "") == detector
    slab = load_track("slab_60e1")
    for track in (TRACK, load_track("ballasted_54e1"), *([slab] if name != "accelerometers" else [])):
        check_place(detector, track, 10 * track.spacing, 27e3)


@pytest.mark.parametrize(
    ("channel", "keys", "message"),
    [
        ({"type": "scale"}, {}, r"channels\.0\.type = 'scale' is not a known type: known are shear_bridge, "),
        ({"x": 200.0}, {}, r"channels\.0\.x = 200 m is out of range: give .* from -100 to 100 m"),
        ({"on": "rail_3"}, {}, r"channels\.0\.on = 'rail_3' is not a known choice: did you mean rail_"),
        ({"name": "Bay 1"}, {}, r"channels\.0: name = 'Bay 1' cannot name a channel: give at most 60"),
        ({"length": 0.0}, {}, r"channels\.0\.length = 0 m is out of range: give .* from 0\.02 to 10 m"),
        ({"z": 0.1}, {}, r"channels\.0\.z is not a known key"),
        ({}, {"rate": 3e3}, r"band = 2000 Hz is above half the rate of 3000 Hz: give up to 1500 Hz, or a higher rate"),
        ({}, {"reach": -1.0}, r"reach = -1 m is out of range"),
    ],
)
def test_what_a_detector_cannot_be_is_refused_in_one_line(channel, keys, message):
    with pytest.raises(InputError, match=message) as refusal:
        made({**GAUGE, **channel}, **keys)
    assert "\n" not in str(refusal.value)


def test_channels_have_names_of_their_own_and_there_is_at_least_one():
    with pytest.raises(InputError, match=r"channels\.1\.name = 'g' is that of another channel: give another name"):
        made(GAUGE, GAUGE)
    with pytest.raises(InputError, match="channels is empty: give at least one"):
        made()
    with pytest.raises(InputError, match="channels has 65 entries: give up to 64"):
        made(*({**GAUGE, "name": f"g{number}"} for number in range(65)))


@pytest.mark.parametrize(
    ("channel", "track", "position", "rate", "message"),
    [
        ({}, dataclasses.replace(TRACK, line=SupportLine()), 6.0, 27e3, "track.line makes them differ: leave out"),
        ({}, TRACK, 6.0, 3e3, "band = 2000 Hz of detector mine is above half the 3000 steps a second .* up to 1500 Hz"),
        (
            {"type": "seat_force"},
            TRACK,
            6.0,
            27e3,
            r"channels\.0\.x = 0\.3 m puts a seat_force at 6\.3 m, beside a sleeper: give 0 m",
        ),
        (
            {"type": "sleeper_acceleration", "x": 0.0},
            load_track("slab_60e1"),
            6.0,
            27e3,
            "is a sleeper_acceleration, and slab track has no sleepers: leave it out",
        ),
    ],
)
def test_where_a_detector_cannot_stand_is_refused_by_name(channel, track, position, rate, message):
    with pytest.raises(InputError, match=message):
        check_place(made({**GAUGE, **channel}), track, position, rate)


def test_a_file_that_is_none_and_a_name_that_is_not_shipped_are_refused(tmp_path):
    with pytest.raises(InputError, match="'shear_arry' is not a known detector: did you mean shear_array"):
        load_detector("shear_arry")
    path = tmp_path / "mine.yaml"
    path.write_text("name: mine\nchannels:\n  - {type: shear_bridge, name: g, on: rail_1, x: 0.3, length: 250 mm}\n")
    assert load_detector(path).channels[0].length == 0.25
