import dataclasses
import textwrap
from pathlib import Path

import pytest

from support.paths import ROOT
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.studies.results import published
from wheelset_track_sim.studies.study import FIGURES, load_study

RUNS = {
    "time_history": 1,
    "frequency_convergence": 10,
    "load_cases": 4,
    "depth": 3 * 61,
    "trajectories": 4,
    "contact_pressure": 3,
    "speed": 3 * 2 * 19,
    "fatigue_depth": 3 * 13,
    "fatigue_speed": 3 * 66,
    "fatigue_flats": 3 * 10,
    **dict.fromkeys(FIGURES, 0),
}


def test_the_papers_studies_are_shipped() -> None:
    assert set(RUNS) <= set(shipped.names("studies"))


@pytest.mark.parametrize("dynamics", ["causal", "paper"])
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name == "depth" else ()) for name in shipped.names("studies")]
)
def test_shipped_studies_load_and_all_their_scenarios_check(name: str, dynamics: str) -> None:
    study = load_study(name)
    assert study.title
    assert study.description
    runs = study.runs([f"dynamics={dynamics}"])
    assert len(runs) == RUNS.get(name, len(runs))
    assert {run.scenario.dynamics for run in runs} <= {dynamics}
    scenario_from(study.base([f"dynamics={dynamics}"]))
    assert len({run.label for run in runs}) == len(runs)
    assert len({run.job.digest() for run in runs}) == len(runs)


def test_load_cases_are_the_shipped_scenarios() -> None:
    cases = {run.points[0].label: run.scenario for run in load_study("load_cases").runs()}
    for label, name in (
        ("no damage", "undamaged"),
        ("damage on wheel 1", "damage_wheel_1"),
        ("damage on wheel 2", "damage_wheel_2"),
        ("damage on both wheels", "damage_both"),
    ):
        assert cases[label].irregularities == load_scenario(name).irregularities
        assert cases[label].settle_on == "smooth"


def test_figures_take_a_wheelset_from_a_file(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(shipped.text("wheelsets", "trailer").replace("name: trailer", "name: mine"), encoding="utf-8")
    changes = [f"wheelset={file}", "output.stress_nodes=[A1]"]
    assert scenario_from(load_study("wheelset_modes").base(changes)).wheelset.name == "mine"


def test_runs_are_the_product_the_last_axis_fastest(small, study_file) -> None:
    runs = load_study(study_file(small)).runs()
    assert [run.label for run in runs] == ["90 km/h, 0 mm", "90 km/h, 0.3 mm", "100 km/h, 0 mm", "100 km/h, 0.3 mm"]
    assert [run.scenario.irregularities[0].h for run in runs] == [0.0, 0.0003, 0.0, 0.0003]
    assert runs[0].scenario.speed == pytest.approx(25.0)


def test_window_is_around_the_reference_position(small, study_file) -> None:
    job = load_study(study_file(small)).runs()[0].job
    assert (job.first_step, job.samples) == (1700, 201)
    shifted = load_study(study_file(small)).runs(["reference_position=2.4"])[0].job
    assert (shifted.first_step, shifted.samples) == (2300, 201)


def test_model_files_become_part_of_the_scenario(small, study_file, tmp_path) -> None:
    text = shipped._folder("tracks").joinpath("ballasted_60e1.yaml").read_text()
    (tmp_path / "soft.yaml").write_text(text.replace("1.2e+8", "0.9e+8"))
    study = load_study(study_file(small | {"set": {"track": str(tmp_path / "soft.yaml")}}))
    assert study.runs()[0].scenario.track.pad.stiffness == 0.9e8
    assert study.runs()[0].job.digest() != load_study(study_file(small)).runs()[0].job.digest()


def test_digest_is_of_all_that_changes_the_result_and_of_nothing_else(small, study_file) -> None:
    job = load_study(study_file(small)).runs()[1].job
    same = dataclasses.replace(job, scenario=dataclasses.replace(job.scenario, name="another"))
    assert same.digest() == job.digest()
    track = job.scenario.track
    softer = dataclasses.replace(track, pad=dataclasses.replace(track.pad, stiffness=9e7))
    others = (
        dataclasses.replace(job, scenario=dataclasses.replace(job.scenario, speed=26.0)),
        dataclasses.replace(job, scenario=dataclasses.replace(job.scenario, track=softer)),
        dataclasses.replace(job, before=0.2),
        dataclasses.replace(job, after=0.2),
        dataclasses.replace(job, outputs=job.outputs[:1]),
        dataclasses.replace(job, histories=("forces",)),
        dataclasses.replace(job, pressures=("wheel_1.max_force",)),
    )
    assert len({job.digest(), *(other.digest() for other in others)}) == 1 + len(others)


def test_outputs_of_fatigue_have_an_sn_curve(small, study_file, tmp_path) -> None:
    text = shipped.text("woehler", "assumed_body").replace("slope: 5.0", "slope: 3.0")
    (tmp_path / "mine.yaml").write_text(text)
    names = {"outputs": ["nodes.A1.damage_ratio", "nodes.A1.rotating_amplitude"]}
    one, other = (load_study(study_file(small | names | {"curve": each})) for each in ("assumed_body", "mine.yaml"))
    assert other.sn_curve.slope == 3.0
    assert one.runs()[0].job.digest() != other.runs()[0].job.digest()
    assert load_study(study_file(small)).sn_curve is None


def lines(**changes):
    panel = {"y": ["wheels.wheel_1.max_force"]} | changes.pop("panel", {})
    return {"drawings": [{"type": "lines", "name": "a", "title": "A", "x": "speed", "panels": [panel]} | changes]}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"vara": {}}, "vara is not a known key: did you mean vary?"),
        ({"scenario": "undamagd"}, "'undamagd' is not a known scenario: did you mean undamaged?"),
        ({"vary": {"sped": [30]}}, "sped is not a known key: did you mean speed?"),
        ({"vary": {"speed": [30, 300]}}, "speed = 300 m/s is out of range"),
        ({"vary": {"irregularities.1.h": [0.001]}}, "irregularities.1: '1' is not an index of a list with 1 entries"),
        ({"vary": {"size": {"A": {"irregularities.0.aa": 0.01}}}}, "irregularities.0.aa is not a known key"),
        ({"vary": {"track": ["ballastd_60e1"]}}, "ballastd_60e1"),
        ({"vary": {"track.sleeper.length": [1.2]}}, "rail_distance = 1.5 m is not below the sleeper length"),
        ({"vary": {"x": {"A": {"speed": 20}}, "speed": [30]}}, "vary changes speed along two axes"),
        ({"vary": [1]}, "vary = [1] is not a mapping"),
        ({"set": {"lag_zero": "printed"}}, "lag_zero = printed does not apply to causal dynamics"),
        ({"outputs": ["wheels.wheel_3.max_force"]}, "outputs.0 = 'wheels.wheel_3.max_force' is not a known output"),
        ({"outputs": ["nodes.D1.max_principal"]}, "did you mean nodes."),
        ({"outputs": []}, "outputs is missing"),
        ({"outputs": ["nodes.A1.damage_ratio"]}, "curve is missing: name the S-N curve of the outputs of fatigue"),
        ({"outputs": ["nodes.A1.damage_ratio"], "curve": "steel"}, "'steel' is not a known woehler"),
        ({"set": {"output.stress_nodes": ["A1", "D1"]}}, "output.stress_nodes.1 = 'D1' is not a known stress node"),
        ({"histories": ["force"]}, "histories.0 = 'force' is not a known choice: did you mean forces?"),
        ({"pressures": ["wheel_1.max"]}, "pressures.0 = 'wheel_1.max' is not a known contact pressure"),
        ({"figures": ["wheelset_mode"]}, "figures.0 = 'wheelset_mode' is not a known figure: did you mean"),
        ({"window": {"before": 2.0}}, "window.before = 2 m begins before the run"),
        ({"window": {"before": -1.0}}, "window.before = -1 m is out of range"),
        ({"drawings": [{"type": "line"}]}, "is not a known type: did you mean lines?"),
        (lines(x="sped"), "drawings.0.x = 'sped' is not a known axis of the study: did you mean speed?"),
        (lines(panels=[]), "drawings.0.panels is empty"),
        (lines(panel={"y": ["wheels.wheel_2.max_force"]}), "drawings.0.panels.0.y = 'wheels.wheel_2.max_force' is not"),
        (lines(panel={"y": ["wheels.wheel_1.max_force", "nodes.A1.max_principal"]}), "give outputs of one unit"),
        (lines(panel={"at": {"irregularities.0.h": 0.001}}), "panels.0.at.irregularities.0.h = 0.001 is not a known"),
        (lines(panel={"at": {"depth": 0.001}}), "drawings.0.panels.0.at.depth is not a known axis"),
        (
            {
                "drawings": [
                    {"type": "histories", "name": "a", "title": "A", "panels": [{"of": "forces", "columns": []}]}
                ]
            },
            "drawings.0.panels.0.of = 'forces' is not kept: put forces into histories",
        ),
        ({"drawings": [{"type": "pressure_maps", "name": "a", "title": "A"}]}, "wheel_1 has no pressure"),
    ],
)
def test_what_cannot_be_used_is_refused_by_name_in_one_line(small, study_file, change, said: str) -> None:
    with pytest.raises(InputError) as refusal:
        load_study(study_file(small | change)).runs()
    assert said in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_refused_scenario_tells_its_place(small, study_file) -> None:
    study = load_study(study_file(small | {"vary": {"speed": [30.0], "irregularities.0.h": [0.001, 0.5]}}))
    with pytest.raises(InputError, match=r"\(run speed 108 km/h, irregularities.0.h 500 mm\)$"):
        study.runs()


def test_a_varied_key_cannot_be_set(small, study_file) -> None:
    with pytest.raises(InputError, match="--set speed=30: the study varies speed itself"):
        load_study(study_file(small)).runs(["speed=30"])


def test_the_papers_values_stand_beside_its_own_cases_alone() -> None:
    force = "wheels.wheel_1.max_force"
    case = load_scenario("damage_wheel_1")
    assert published(case, force) == 358e3
    assert published(case, "nodes.C1.max_principal") == 88.1e6
    assert published(load_scenario("damage_wheel_1", ["irregularities.0.h=0"]), force) == 131e3
    assert published(load_scenario("damage_wheel_1", ["max_frequency=2500"]), force) == 358e3
    for change in ("irregularities.0.h=0.0019", "max_frequency=2250", "reference_position=2.1", "speed=28"):
        assert published(load_scenario("damage_wheel_1", [change]), force) != published(case, force)
    for withheld in ("damage_wheel_2", "damage_both"):
        assert not published(load_scenario(withheld), force) > 0


def test_the_study_of_the_documentation_can_be_run(tmp_path) -> None:
    text = (ROOT / "docs" / "reference" / "studies.md").read_text().partition("## A study of your own\n")[2]
    block = text[text.index("    title: ") :].partition("\n\n")[0]
    (tmp_path / "mine.yaml").write_text(textwrap.dedent(block))
    runs = load_study(tmp_path / "mine.yaml").runs()
    assert len(runs) == 2 * 5 * 2
    assert {run.scenario.track.pad.stiffness for run in runs} == {300e6}


def test_the_scenario_of_a_study_is_a_file_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    for folder, speed in ((tmp_path / "here", 31), (tmp_path, 32)):
        text = shipped.text("scenarios", "undamaged").replace("speed: 27.7777778", f"speed: {speed}")
        (folder / "mine.yaml").write_text(text, encoding="utf-8")
    study = tmp_path / "study.yaml"
    text = "title: Mine\nscenario: mine.yaml\noutputs: [wheels.wheel_1.max_force]\n"
    study.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path / "here")
    for path in (study, "../study.yaml"):
        assert [run.scenario.speed for run in load_study(path).runs()] == [32]
    study.rename("study.yaml")
    (tmp_path / "here" / "mine.yaml").rename("other.yaml")
    with pytest.raises(InputError, match=r"mine\.yaml cannot be read"):
        load_study("study.yaml").runs()
