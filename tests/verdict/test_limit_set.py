"""Sets of limits as files: shipped ones have sources, and others are validated."""

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.verdict.limit_set import load_limits

STRESS = "{above: 150 MPa, level: warning, action: inspect, source: a drawing, zone: body, grade: EA1N, nodes: [A1]}"


@pytest.mark.parametrize("name", shipped.names("limits"))
def test_every_shipped_limit_has_a_source_and_an_action(name):
    limits = load_limits(name)
    assert limits.name == name
    for limit in (*limits.force, *limits.damage_length, *limits.axle):
        assert len(limit.source) > 20
        assert limit.action
    assert not limits.axle  # no source of theirs has limits of axle stress


def test_limits_are_those_of_their_sources():
    sweden, usa, britain = map(load_limits, ("trafikverket", "fra", "network_rail"))
    assert [limit.above for limit in sweden.force] == [350e3]
    assert [limit.above for limit in sweden.damage_length] == [0.06]
    kip = 4448.2216
    assert [limit.above for limit in usa.force] == pytest.approx([80 * kip, 90 * kip], rel=1e-5)
    assert [limit.above for limit in britain.force] == [200e3]


def test_none_is_no_set():
    assert load_limits("none") is None


def test_a_file_of_ones_own(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text(f"name: mine\naxle:\n  - {STRESS}\n")
    (limit,) = load_limits(path).axle
    assert (limit.above, limit.nodes, limit.zone) == (150e6, ("A1",), "body")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: mine", "are empty: give force"),
        ("name: mine\nforce: [{above: 350 kN, level: alarm, action: stop}]", "force.0.source is missing"),
        ("name: mine\nforce: [{above: 350 kN, level: alarm, action: stop, source: ' '}]", "source is empty"),
        ("name: mine\nforce: [{above: 350 kN, level: stop, action: stop, source: x}]", "force.0.level"),
        ("name: mine\nforce: [{above: 60 mm, level: alarm, action: stop, source: x}]", "force.0.above"),
        ("name: mine\nforces: []", "'forces'|forces is not a known key"),
        (f"name: mine\naxle: [{STRESS.replace('[A1]', '[]')}]", "nodes is empty"),
        (f"name: mine\naxle: [{STRESS.replace('150 MPa', '10 Pa')}]", "axle.0.above"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "own.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as refusal:
        load_limits(path)
    assert "\n" not in str(refusal.value)


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(InputError, match="trafikverket"):
        load_limits("trafikverkt")
