"""Tutorials and how-to pages: all that they have their readers save and run, with the lines that they show."""

import pytest

import wheelset_track_sim as wts
from support.pages import follow
from support.paths import ROOT

DOCS = ROOT / "docs"
WTS = ".venv/bin/wheelset-track-sim"
SETUP = "python3 tools/setup_env.py"
LEFT_OUT = {
    "tutorials/paper": tuple(
        f"{WTS} study {name}"
        for name in ("wheelset_receptances", "moving_green_functions", "time_history", "load_cases")
    ),
    "tutorials/own_wheelset": (f"{WTS} study",),
    "tutorials/cluster": (SETUP, ".venv/bin/dask", f"{WTS} study"),
    "howto/profile": (),
    "howto/stress_node": (),
    "howto/imported_modes": (),
    "howto/speed_plan": (f"{WTS} report", f"{WTS} set", f"{WTS} call"),
    "howto/damage_growth": (f"{WTS} report", f"{WTS} set"),
    "howto/export": (
        SETUP,
        f"{WTS} run flat_fresh --out flat.xlsx",
        f"{WTS} study mine.yaml",
        f"{WTS} show",
        f"{WTS} report",
    ),
    "howto/compare_measured": (
        "time [s],",
        "0.0028766,",
        f"{WTS} report",
        f"{WTS} resimulate",
        f"{WTS} compare shallow",
    ),
    "howto/fatigue": (
        *(f"{WTS} run", f"{WTS} study", f"{WTS} fatigue flat.mcap", f"{WTS} fatigue axle_7.ledger"),
        *(f"{WTS} fatigue damage_wheel_1 --curve", f"{WTS} fatigue damage_wheel_1 --service"),
        *(f"{WTS} fatigue damage_wheel_1 --mission", f"{WTS} fatigue press_fit", "ros2 "),
    ),
    "howto/crack": (f"{WTS} list", f"{WTS} crack damage_wheel_1 --depth '2 mm' --growth my_steel.yaml"),
    "howto/wayside": (f"{WTS} study blind_zone", f"{WTS} node", f"{WTS} echo"),
    "howto/qos": (f"{WTS} echo", "ros2 "),
    "howto/maps": (f"{WTS} map", f"{WTS} study", "import xarray"),
    "howto/dataset": (f"{WTS} dataset", "import xarray", ".venv/bin/python"),
    "howto/fleet_by_passage": (".venv/bin/python", "import wheelset_track_sim"),
    "howto/fleet_damage": ("ros2 ", f"{WTS} node", f"{WTS} call"),
}
"""Pages with the commands that are not run here: they take long, or need a node or a cluster. Other tests run these."""


@pytest.mark.slow
@pytest.mark.parametrize("name", LEFT_OUT)
def test_a_page_does_what_it_says(name, tmp_path, monkeypatch):
    if name == "howto/qos":
        pytest.importorskip("rclpy", reason="make setup brings it")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    left_out = LEFT_OUT[name]
    skipped = follow(DOCS / f"{name}.md", left_out)
    for file in tmp_path.rglob("*.yaml"):
        if "\nvary:" in file.read_text():
            assert wts.load_study(file).runs()
    assert [each for each in left_out if not any(line.startswith(each) for line in skipped)] == []
