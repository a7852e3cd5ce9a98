"""Scenarios and studies in which something else stands in any place: one line, or they can be used."""

import copy
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.schema import read
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.studies.study import Study

STRANGE: tuple[Any, ...] = (
    5,
    -1,
    0.5,
    "x",
    "",
    {"a": 1},
    {5: 1},
    {"type": {"b": 1}},
    [1],
    [],
    [[1]],
    None,
    True,
    10**29,
    float("nan"),
)


def places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in entries:
        yield from places(value, (*path, key))


def with_entry(data: Any, path: tuple[Any, ...], value: Any) -> Any:
    """The data with ``value`` in a place."""
    if not path:
        return value
    made = copy.deepcopy(data)
    place = made
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return made


def usable_or_refused(use: Any, data: Any) -> None:
    told = ""
    try:
        use(data)
    except InputError as refusal:
        told = str(refusal)
    assert "\n" not in told


CASES = [(kind, name) for kind in ("scenarios", "studies", "wheelsets", "tracks") for name in shipped.names(kind)]


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_anything_in_any_place(kind: str, name: str, recwarn: pytest.WarningsRecorder) -> None:
    data = shipped.load_yaml(kind, name)
    base = load_scenario("undamaged").to_mapping()
    use = {
        "scenarios": scenario_from,
        "studies": lambda found: read(Study, found, ""),
        "wheelsets": lambda found: scenario_from(base | {"wheelset": found}),
        "tracks": lambda found: scenario_from(base | {"track": found}),
    }[kind]
    chance = random.Random(name)
    everywhere = [*places(data)]
    for path in chance.sample(everywhere, min(len(everywhere), 40)):
        usable_or_refused(use, with_entry(data, path, chance.choice(STRANGE)))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("speed: 1" + "0" * 400, "a has a whole number of 401 digits: give up to 30"),
        ("speed: [-1" + "0" * 40 + "]", "a has a whole number of 41 digits: give up to 30"),
        ("speed: 1" + "0" * 5000, "a is not YAML"),
        ("&a [*a]", "a holds more than 2000000 values"),
    ],
)
def test_numbers_and_lists_are_bounded(text: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        parse(text, "a")


def test_aliases_in_what_is_trusted_are_bounded(tmp_path: Path) -> None:
    lines = ["l0: &l0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 10)}]" for n in range(1, 10)]
    path = tmp_path / "bomb.yaml"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match="holds more than 2000000 values: give a smaller one"):
        load_scenario(path)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"scenario": 5}, "scenario = 5 is neither a name, nor a file"),
        ({"set": {5: 1}}, "set: 5 is not text, and scenario keys must be"),
        ({"vary": 5}, "vary = 5 is not a mapping of scenario keys"),
        ({"vary": {"size": {"A": {7: 1}}}}, r"vary\.size\.A: 7 is not text"),
    ],
)
def test_a_study_needs_names_where_names_belong(change: dict[str, Any], reason: str) -> None:
    study = {"title": "t", "outputs": ["wheels.wheel_1.max_force"]}
    with pytest.raises(InputError, match=reason):
        read(Study, study | change, "")
