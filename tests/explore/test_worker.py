"""The worker: the latest request of a page wins, pages take turns, and what is closed leaves nothing."""

import threading

import pytest

from wheelset_track_sim.explore.worker import Worker


@pytest.fixture
def worker():
    made = Worker()
    yield made
    made.close()


@pytest.fixture
def held(worker):
    """The worker with a job at hand, and what lets it go on."""
    begun, go = threading.Event(), threading.Event()

    def hold():
        begun.set()
        go.wait()

    worker.submit("holding", "hold", hold)
    begun.wait()
    yield go.set
    go.set()


def finished(worker):
    """Wait for all that was submitted before."""
    done = threading.Event()
    worker.submit("end", "end", done.set, rank=99)
    assert done.wait(10)


def test_the_latest_request_of_a_page_wins(worker, held):
    done = []
    for number in range(1000):
        worker.submit("page", "view", lambda number=number: done.append(number))
    assert worker.superseded("page", "view")
    held()
    finished(worker)
    assert done == [999]
    assert not worker.superseded("page", "view")


def test_pages_take_turns_and_ranks_go_first(worker, held):
    done = []
    worker.submit("one", "map", lambda: done.append("map"), rank=2)
    worker.submit("one", "view", lambda: done.append("one"))
    worker.submit("two", "view", lambda: done.append("two"))
    worker.submit("one", "view", lambda: done.append("one again"))
    assert worker.busy(2)
    assert not worker.busy(0)
    held()
    finished(worker)
    assert done == ["one again", "two", "map"]


def test_a_closed_page_is_forgotten(worker, held):
    done = []
    for kind in ("view", "moment"):
        worker.submit("closed", kind, lambda: done.append("closed"))
    worker.submit("open", "view", lambda: done.append("open view"))
    worker.submit("open", "map", lambda: done.append("open map"))
    worker.drop("closed")
    worker.drop("open", "map")
    held()
    finished(worker)
    assert done == ["open view"]


def test_the_thread_ends(worker, held):
    worker.submit("page", "view", lambda: None)
    worker.close()
    assert worker.superseded("page", "view")  # what is at hand breaks off
    held()
    worker._thread.join(10)
    assert not worker._thread.is_alive()
