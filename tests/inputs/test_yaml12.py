"""YAML that is written is read again, with every version of the library."""

from wheelset_track_sim.inputs.yaml12 import dump, parse


def test_a_long_text_of_lines_comes_back():
    table = {"table": "\n".join(f"{number / 4} 0.78459" for number in range(100)), "name": "a " * 100}
    assert parse(dump(table), "it") == table
