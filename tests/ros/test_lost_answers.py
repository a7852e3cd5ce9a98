"""Answers that the middleware does not deliver are counted; the warning is that of rclpy, at the place of rclpy."""

import threading
import warnings
from types import SimpleNamespace

import pytest

pytestmark = pytest.mark.ros

TIMEOUT = "failed to send response (timeout): client will not receive response"


class Log:
    def __init__(self):
        self.lines = []

    def warning(self, line):
        self.lines.append(line)


@pytest.fixture
def watched():
    """A service whose answers are sent or not, what watches it, its log and its clock."""
    from wheelset_track_sim.ros import lost_answers

    log, now, delivered = Log(), SimpleNamespace(s=0.0), []

    def send(response, header):
        if header:
            delivered.append(response)
        else:
            warnings.warn(TIMEOUT, RuntimeWarning, stacklevel=1)  # by the same line each time, as rclpy does

    service = SimpleNamespace(srv_name="/node/set_speed", send_response=send)
    with warnings.catch_warnings():
        lost_answers._catch_warnings.cache_clear()
        lost = lost_answers.LostAnswers(log, lambda: now.s)
        lost.watch(service)
        yield SimpleNamespace(send=service.send_response, lost=lost, log=log, now=now, delivered=delivered)
    lost_answers._catch_warnings.cache_clear()


def test_all_is_well_while_answers_are_delivered(watched):
    watched.send("answer", True)
    status = watched.lost.status()
    assert (status.level, status.message, status.values) == (0, "all answers are sent", (("lost_answers", "0"),))
    assert (watched.delivered, watched.log.lines) == (["answer"], [])


def test_each_lost_answer_counts_and_is_a_warning_for_a_minute(watched):
    for _ in range(3):
        watched.send("answer", False)
    status = watched.lost.status()
    assert (status.level, status.values) == (1, (("lost_answers", "3"),))
    assert status.message == "3 answers lost, the latest of /node/set_speed"
    assert len(watched.log.lines) == 3
    assert watched.log.lines[0].startswith("/node/set_speed: an answer is lost")
    watched.now.s = 61.0
    assert watched.lost.status().level == 0
    assert watched.lost.status().values == (("lost_answers", "3"),)


def test_threads_do_not_share_their_losses(watched):
    threads = [threading.Thread(target=lambda: [watched.send("x", n % 2) for n in range(100)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert watched.lost.status().values == (("lost_answers", "200"),)


def test_other_warnings_stay_warnings(watched):
    with pytest.warns(RuntimeWarning, match="another"):
        warnings.warn("another", RuntimeWarning, stacklevel=1)
    assert watched.lost.status().level == 0


def test_what_rclpy_warns_of_is_what_is_caught():
    """The text is that of the installed rclpy."""
    from pathlib import Path

    import rclpy

    [library] = Path(rclpy.__file__).parent.glob("_rclpy_pybind11*.so")
    assert b"failed to send response (timeout): %s" in library.read_bytes()
