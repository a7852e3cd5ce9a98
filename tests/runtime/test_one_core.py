import threading

import pytest
from threadpoolctl import threadpool_info

from wheelset_track_sim.runtime.one_core import on_one_core, one_core


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture
def several() -> set[int]:
    found = threads()
    if found == {1}:
        pytest.skip("one thread of linear algebra from the start")
    return found


def in_thread(work) -> None:
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def test_the_limit_holds_in_any_thread_and_is_lifted(several) -> None:
    found: list[set[int]] = []
    limited = on_one_core(lambda: found.append(threads()))
    limited()  # the first thread to set a limit must not stay the only one
    in_thread(limited)
    limited()
    in_thread(limited)
    assert found == [{1}] * 4
    assert threads() == several


def test_the_last_one_out_lifts_the_limit_whoever_set_it(several) -> None:
    inside, leave = threading.Event(), threading.Event()

    def other() -> None:
        with one_core():
            inside.set()
            leave.wait(10.0)

    thread = threading.Thread(target=other)
    thread.start()
    inside.wait(10.0)
    with one_core():
        leave.set()
        thread.join()
        assert threads() == {1}
    assert threads() == several
