"""``identify``: what it prints, writes and refuses."""

import dataclasses
import json

import pytest

from support.toy import toy_simulator
from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.cli.identify import Options, data_of
from wheelset_track_sim.identification.files import Given
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.scenario import load_scenario


@pytest.mark.slow
def test_a_peak_gives_sizes_a_picture_and_a_scenario(tmp_path, capsys):
    out, picture = tmp_path / "damage.yaml", tmp_path / "fit.png"
    words = ["identify", "--force", "250 kN", "--speed", "100 km/h", "--kind", "flat", "--kind", "none"]
    assert main([*words, "--out", str(out), "--picture", str(picture), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    flat, none = found["kinds"]
    assert (flat["kind"], flat["explains"], none["kind"], none["explains"]) == ("flat", True, "none", False)
    length = flat["parameters"]["length_m"]
    assert 0.035 < length["low"] < 0.042 < length["estimate"] < 0.055 < length["high"] < 0.075
    assert picture.stat().st_size > 5000
    (damage,) = load_scenario(out).irregularities
    assert damage.length == pytest.approx(length["estimate"], rel=0.02)
    assert main([*words, "--out", str(out)]) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "give either files of data, or a peak by --force"),
        (["--force", "90 kN"], "force = 90000 N is not above the static wheel load of 98100 N"),
        (["--force", "250 kN", "--kind", "polygon"], "invalid choice: 'polygon'"),
        (["--force", "250 kN", "--speed", "20", "--speed", "30"], "--speed is given 2 times for one peak"),
        (["none.csv", "--speed", "20", "--speed", "30"], "--speed is given 2 times for 1 files"),
        (["none.csv", "--speed", "20"], "none.csv does not exist"),
        (["--force", "250 kN", "--picture", "fit.txt"], "fit.txt is not a picture"),
        (["--force", "250 kg/s"], "--force"),
    ],
)
def test_what_cannot_be_is_refused(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["identify", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_changes_are_those_of_the_scenario_of_a_bag(tmp_path):
    run = toy_simulator("axle_load=170000", like="damage_wheel_1")
    with record(tmp_path / "run.mcap", run) as push:
        push(run.advance(4000))
    options = Options(changes=["track.pad.stiffness=9e7"])
    scenario, (observation,) = data_of([tmp_path / "run.mcap"], None, Given(), options)
    own = run.scenario.track
    assert scenario.track == dataclasses.replace(own, pad=dataclasses.replace(own.pad, stiffness=9e7))
    assert (scenario.axle_load, observation.axle_load) == (170e3, 170e3)
    assert scenario.irregularities == ()
