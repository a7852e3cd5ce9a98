"""What detectors beside the track read, as outputs of a study."""

import pytest

from wheelset_track_sim import Simulator
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.studies import Study
from wheelset_track_sim.studies.evaluate import evaluate, models, program
from wheelset_track_sim.studies.outputs import label_of, unit_of
from wheelset_track_sim.studies.study import EvaluationWindow
from wheelset_track_sim.wayside.watch import passages

READ = "wayside.shear_single.wheel_1_peak_read"
TRUE = "wayside.shear_single.wheel_1_peak_force"
STANDING = [{"detector": "shear_single", "position": 1.2}]


def made(after, *outputs):
    return Study(title="read", set={"wayside": STANDING}, outputs=outputs, window=EvaluationWindow(0.6, after))


@pytest.mark.slow
def test_a_study_keeps_what_a_detector_reads():
    [run] = made(0.6, READ, TRUE, "wheels.wheel_1.max_force").runs()
    found = evaluate(run.job, program()).values
    block = Simulator(run.scenario, models=models(run.scenario)).advance(2401)
    [passage] = passages(run.scenario.wayside, run.scenario.track, 1e-3, [block])
    assert found[READ] == passage.verdicts[0].read.peak
    assert found[TRUE] == passage.verdicts[0].true.peak == found["wheels.wheel_1.max_force"]


def test_outputs_have_words_and_units():
    assert (label_of(READ), unit_of(READ)) == ("force read, wheel 1, shear single, max", "N")


def test_what_a_run_does_not_have_is_refused():
    with pytest.raises(InputError, match=r"'wayside\.shear_array\.wheel_1_peak_read' is not a known output"):
        made(0.6, "wayside.shear_array.wheel_1_peak_read").runs()
    with pytest.raises(InputError, match=r"window\.after = 0\.2 m ends before the wheelset has passed detector shear_"):
        made(0.2, READ).runs()
    assert made(0.451, READ).runs()
