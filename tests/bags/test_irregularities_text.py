"""All irregularities in states of bags, of this version and of earlier ones."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.bags.definitions import converter, deserialise, full_name, schema, texts, typestore
from wheelset_track_sim.bags.irregularities_text import irregularities_text, listed_irregularities
from wheelset_track_sim.bags.messages import state_message
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.yaml12 import dump, parse
from wheelset_track_sim.irregularities.listing import listed
from wheelset_track_sim.scenario import load_scenario


@pytest.mark.parametrize("name", shipped.names("scenarios"))
def test_the_text_of_a_state_is_what_set_irregularities_takes(name):
    scenario = load_scenario(name)
    assert listed(irregularities_text(scenario.to_yaml()), lambda file: file) == scenario.irregularities


texts_of_users = st.text(max_size=200)


@given(st.lists(st.fixed_dictionaries({"type": texts_of_users, "table": texts_of_users})), texts_of_users)
def test_the_text_is_that_list_and_nothing_else_of_the_scenario(entries, name):
    text = dump({"name": name, "irregularities": entries, "line_length": None})
    assert listed_irregularities(text) == tuple(entries)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", None),
        ("name: x\n", ()),
        ("irregularities:\n", ()),
        ("irregularities: []\n", ()),
        ("irregularities: [{type: flat}]\nname: x\n", ({"type": "flat"},)),
        ("irregularities: 3\n", None),
        ("irregularities: [3]\n", None),
        ("irregularities: [\n", None),
        ("irregularities: &a [*a]\n", None),
    ],
)
def test_what_is_no_list_of_irregularities_is_unknown(text, found):
    assert listed_irregularities(text) == found


def test_a_state_of_an_earlier_version_is_converted(make_block, make_state):
    """Its definition lacks the field: subscribers of this version get it from the scenario."""
    scenario = load_scenario("flat_fresh")
    message = state_message(dataclasses.replace(make_state(make_block(0, 10)), scenario=scenario.to_yaml()), 0)
    field = next(line for line in texts()["SimulationState"].splitlines() if line.startswith("string irregularities"))
    older = schema("SimulationState").replace(field, "")
    older_bytes = _without_last_text(message.cdr, message.fields["irregularities"])
    found = deserialise("SimulationState", converter("SimulationState", "ros2msg", older.encode())(older_bytes))
    assert parse(found.irregularities, "it") == scenario.to_mapping()["irregularities"]
    assert found.scenario == scenario.to_yaml()
    assert typestore().serialize_cdr(found, full_name("SimulationState")) == message.cdr


def _without_last_text(cdr, text):
    encoded = text.encode() + b"\0"
    assert cdr.endswith(encoded)
    return cdr[: -len(encoded) - 4]
