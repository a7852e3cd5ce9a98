import io
import math

import pytest
from rich.console import Console

from wheelset_track_sim.report import summary_table
from wheelset_track_sim.report.table import description, rows


def by_label(run):
    return {row.label: row for row in rows(run)}


def text_of(run) -> str:
    out = io.StringIO()
    Console(file=out, width=120).print(summary_table(run))
    return out.getvalue()


def test_a_published_case_stands_beside_the_paper(make_survey):
    found = by_label(make_survey("damage_wheel_1", spikes=[(1.8, 300e3), (4.5, 320e3)]))
    force = found["Contact force wheel 1, max"]
    assert (force.run, force.passage, force.paper) == (320.0, 300.0, 358.0)
    assert force.cells() == ("320.0 kN", "300.0 kN", "358 kN", "-16.2 %")
    assert found["Contact force wheel 1, min"].cells() == ("0.0 kN", "0.0 kN", "0 kN", "")
    lost = found["Time without contact wheel 1"]
    assert lost.run == pytest.approx(2 * 0.036, rel=1e-6)
    assert lost.passage == pytest.approx(0.036, rel=1e-6)
    stress = found["Max. principal stress C1, max"]
    assert (stress.run, stress.paper) == (pytest.approx(40.0), pytest.approx(88.1))


def test_undamaged_figures(make_survey):
    found = by_label(make_survey("undamaged"))
    printed = {label: row.paper for label, row in found.items() if not math.isnan(row.paper)}
    assert printed == pytest.approx(
        {
            "Contact force wheel 1, max": 131,
            "Contact force wheel 2, max": 128,
            "Max. principal stress A1, max": 69.3,
            "Max. principal stress B1, max": 66.6,
            "Max. principal stress C1, max": 61.8,
            "Dynamic factor wheel 1": 131 / 98.1,
            "Dynamic factor wheel 2": 128 / 98.1,
        }
    )


@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("damage_wheel_2", []),
        ("damage_both", []),
        ("damage_wheel_1", ["irregularities.0.h=0.001"]),
        ("damage_wheel_1", ["irregularities.0.angle=0.1"]),
        ("undamaged", ["speed=30"]),
        ("undamaged", ["axle_load=150000"]),
    ],
)
def test_what_the_paper_does_not_print_stands_alone(make_survey, scenario, changes):
    run = make_survey(scenario, changes, name="damage_wheel_1")
    assert run.passage is None
    assert all(math.isnan(row.paper) for row in rows(run))
    assert "paper" not in text_of(run)


def test_content_counts_and_not_the_name(make_survey):
    assert make_survey("undamaged", ["name=mine"]).passage is not None


def test_a_changed_run_is_not_the_case(make_survey):
    assert make_survey("undamaged", revisions=[(5000, ["axle_load=150000"])]).passage is None


@pytest.mark.parametrize(("length", "compared"), [(1.0, False), (2.6, False), (2.712, True), (9.0, True)])
def test_the_passage_must_be_in_the_run(make_survey, length, compared):
    assert (make_survey("undamaged", length=length).passage is not None) == compared


@pytest.mark.parametrize("chunk", [1, 1389, 10_000])
def test_the_passage_is_three_bays(make_survey, chunk):
    passage = make_survey("undamaged", length=3.0, chunk=chunk).passage.samples
    assert passage.position[0] == pytest.approx(0.9, abs=1e-9)
    assert len(passage) == pytest.approx(1800, abs=1)


def test_a_bag_without_scenario_has_a_table(make_survey):
    run = make_survey("undamaged", spacing=math.nan, known=False)
    assert run.passage is None
    assert "100.0 kN" in text_of(run)
    assert "Dynamic factor" not in text_of(run)


def test_the_dynamic_factor_is_over_the_force_at_rest(make_survey):
    found = by_label(make_survey(spikes=[(1.8, 294.3e3)]))
    assert found["Dynamic factor wheel 1"].cells()[0] == "3.00"
    assert found["Dynamic factor wheel 2"].run == pytest.approx(90 / 98.1)
    changed = by_label(make_survey(revisions=[(3000, ["axle_load=150000"])]))
    assert not any("Dynamic" in label for label in changed)


def test_terminal_table_reads_well(make_survey):
    text = text_of(make_survey("damage_wheel_1", spikes=[(1.8, 300e3)]))
    assert "100 km/h, axle load 20 t, causal dynamics" in text
    for part in ("300.0 kN", "358 kN", "-16.2 %", "60.0 MPa", "93.7 MPa", "Table 3", "0.9 to 2.7 m"):
        assert part in text


def test_bending_amplitudes_are_of_the_bending_stress_without_its_mean(make_survey):
    amplitudes = {"A1": 60.0, "B1": 50.0, "C1": 40.0}  # of stresses that do not vary at the top
    given = ["loads={stresses: [{node: A1, yy: 20e6}]}"]
    for changes, bending in (([], amplitudes), (given, amplitudes | {"A1": 40.0})):
        found = by_label(make_survey("undamaged", changes))
        for node, of in bending.items():
            assert found[f"Bending amplitude {node}"].cells() == (f"{of:.1f} MPa", "", "", "")
    for unknown in ({"changes": ["loads={press_fit: {wheels: 1e-4}}"]}, {"known": False}):
        assert not any("amplitude" in label for label in by_label(make_survey("undamaged", **unknown)))


def test_a_range_of_speeds_is_told(make_survey):
    run = make_survey("undamaged", revisions=[(3000, ["speed=30"])])
    assert description(run).startswith("100 to 108 km/h, axle load 20 t")
    assert run.speeds == ((0.0, pytest.approx(100 / 3.6)), (pytest.approx(0.108, rel=1e-6), 30.0))
