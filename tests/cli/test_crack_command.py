"""``crack`` of a bag and of a scenario."""

import json

import numpy as np
import pytest

from support.toy import toy_simulator
from wheelset_track_sim.cli.command_line import main
from wheelset_track_sim.fatigue.crack import CrackSpectrum, crack_life
from wheelset_track_sim.fatigue.growth import load_crack_growth
from wheelset_track_sim.live.run_messages import record

STEPS = 6 * 2713


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("crack") / "run.mcap"
    run = toy_simulator("settle_on=surfaces", like="damage_wheel_1")
    with record(path, run) as push:
        while run.next_step < STEPS:
            push(run.advance(STEPS - run.next_step))
    return path


def printed(capsys, *arguments):
    assert main(["crack", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_what_is_left_is_a_band_with_its_source(bag, capsys):
    found = printed(capsys, bag, "--depth", "4 mm", "--growth", "assumed_steel")
    assert found["growth"]["source"].startswith("assumed")
    assert found["growth"]["assumed"] is True
    assert [*found["nodes"]] == ["A1", "B1", "C1"]
    for node in found["nodes"].values():
        assert node["diameter_m"] == pytest.approx(0.18)
        left = node["left_m"]
        assert left["slow"] is None or left["slow"] > 2 * left["middle"]
        assert left["middle"] > 2 * left["fast"]
        assert node["inspection_interval_m"] == left["fast"] / 2
        curve = node["growth"]["fast"]
        assert (curve["depth_m"][0], curve["distance_m"][0]) == (pytest.approx(0.004), 0.0)
        assert curve["distance_m"][-1] == left["fast"]
    # of the order of one cycle a turn of the static stress
    law = load_crack_growth("assumed_steel").at("fast")
    static = CrackSpectrum(np.array([130e6]), np.array([0.0]), np.array([1 / 2.713]))
    assert found["nodes"]["A1"]["left_m"]["fast"] == pytest.approx(crack_life(static, law, 0.004, 0.18).left, rel=0.6)


def test_people_see_what_depends_on_the_law(bag, capsys):
    assert main(["crack", str(bag), "--depth", "4 mm", "--growth", "assumed_steel", "--inspections", "3"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "a crack of 4 mm" in shown
    assert "* distance left, fast" in shown
    assert "* inspect every (fast / 3)" in shown
    assert "* by the law of Paris assumed_steel; source: assumed: the fast end has" in shown


def test_a_law_without_a_source_and_a_bored_axle_are_refused(bag, tmp_path, capsys):
    law = tmp_path / "law.yaml"
    assert main(["init", "crack", "assumed_steel", str(law)]) == 0
    text = law.read_text()
    law.write_text(text[: text.index("source:")] + text[text.index("law: paris") :])
    capsys.readouterr()
    assert main(["crack", str(bag), "--depth", "4 mm", "--growth", str(law)]) == 2
    assert "source is missing" in capsys.readouterr().err
    arguments = ["crack", "undamaged", "--set", "wheelset.axle.bore=60 mm", "--depth", "4 mm"]
    assert main([*arguments, "--growth", "assumed_steel"]) == 2
    assert "the axle is bored, and the stress intensity" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--depth", "0 mm"], "depth = 0 m is out of range: give more than 0 m, up to 0.09 m"),
        (["--depth", "4 mm", "--inspections", "0"], "--inspections 0 is out of range: give 1 to 100"),
        (["--depth", "4 mm", "--growth", "steel"], "'steel' is not a known crack"),
        (["--depth", "4 mm", "--distance", "2 m"], "has 2 m, less than one turn of 2.713 m"),
    ],
)
def test_what_cannot_be_is_refused(bag, capsys, arguments, words):
    assert main(["crack", str(bag), "--growth", "assumed_steel", *arguments]) == 2
    assert words in capsys.readouterr().err
