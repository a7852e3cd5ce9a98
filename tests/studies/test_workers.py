import multiprocessing
import os
import time

import pytest

from wheelset_track_sim.studies.workers import THREADS, on_this_machine


def square(number: int) -> int:
    if number < 0:
        raise ValueError(f"{number} is negative")
    return number * number


def die_of_seven(number: int) -> int:
    if number == 7:
        os._exit(9)
    time.sleep(0.05)
    return number


def environment(name: str) -> str | None:
    return os.environ.get(name)


@pytest.mark.slow
def test_a_failing_job_does_not_end_the_others() -> None:
    found = dict(on_this_machine(square, {1: 2, 2: -3, 3: 4}, 2))
    assert (found[1], found[3]) == (4, 16)
    assert isinstance(found[2], ValueError)
    assert str(found[2]) == "-3 is negative"


@pytest.mark.slow
def test_a_job_whose_process_dies_is_found_and_the_others_are_done() -> None:
    jobs = {10 * number: number for number in range(4, 11)}
    found = dict(on_this_machine(die_of_seven, jobs, 3))
    assert str(found.pop(70)) == "its process died: out of memory, or a crash"
    assert found == {10 * number: number for number in (4, 5, 6, 8, 9, 10)}


@pytest.mark.slow
def test_processes_have_one_thread_each_and_the_environment_stays(monkeypatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    found = dict(on_this_machine(environment, dict(enumerate(THREADS)), 1))
    assert set(found.values()) == {"1"}
    assert os.environ["OMP_NUM_THREADS"] == "3"


@pytest.mark.slow
def test_a_pool_that_is_left_early_ends_its_processes() -> None:
    ended = on_this_machine(time.sleep, {1: 0.0, 2: 60.0}, 2)
    assert next(ended) == (1, None)
    begun = time.monotonic()
    ended.close()
    assert time.monotonic() - begun < 30
    assert not multiprocessing.active_children()
