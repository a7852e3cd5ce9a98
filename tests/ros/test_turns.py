"""Requests that wait for one another, with services of rclpy."""

import threading

import pytest

pytestmark = pytest.mark.ros


def test_those_that_find_no_room_are_refused_and_the_rest_answered_in_order(make_client):
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
    from rclpy.qos import QoSProfile
    from std_srvs.srv import Trigger

    from wheelset_track_sim.ros.turns import BUSY, REQUESTS, WAITING, in_turns

    go_on, begun, order = threading.Event(), threading.Event(), []

    def answer(request, response):
        begun.set()
        go_on.wait()
        order.append(threading.get_ident())
        response.success, response.message = True, str(len(order))
        return response

    server, client = make_client("server"), make_client("client")
    server.node.create_service(
        Trigger, "/ask", answer, qos_profile=REQUESTS, callback_group=MutuallyExclusiveCallbackGroup()
    )
    [turns] = in_turns(server.node)
    asked = client.node.create_client(Trigger, "/ask", qos_profile=QoSProfile(depth=2 * WAITING))
    assert asked.wait_for_service(20.0)
    first = asked.call_async(Trigger.Request())
    assert begun.wait(20.0)
    sent = [asked.call_async(Trigger.Request()) for _ in range(WAITING + 9)]
    server.until(lambda: sum(each.done() for each in sent) == 9)
    assert all((each.result().success, each.result().message) == (False, BUSY) for each in sent[WAITING:])
    go_on.set()
    server.until(lambda: all(each.done() for each in sent))
    assert [int(each.result().message) for each in [first, *sent[:WAITING]]] == list(range(1, WAITING + 2))
    assert len(set(order)) == 1
    turns.close()
