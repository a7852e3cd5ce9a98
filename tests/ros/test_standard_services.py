"""The standard services of simulators, where their package is installed."""

import threading

import pytest

from support.service_calls import end

pytestmark = [pytest.mark.ros, pytest.mark.slow]

WORLD = """
name: mine
speed: 20 m/s
axle_load: 20 t
"""


@pytest.fixture
def msg():
    return pytest.importorskip("simulation_interfaces.msg")


@pytest.fixture
def ask(client, msg):
    from simulation_interfaces import srv

    def ask(name, **fields):
        kind = "".join(word.capitalize() for word in name.split("_"))
        return client.call(name, getattr(srv, kind), again=False, **fields)

    return ask


@pytest.fixture
def state(ask):
    return lambda: ask("get_simulation_state").state.state


@pytest.fixture
def become(ask, msg):
    return lambda state: ask("set_simulation_state", state=msg.SimulationState(state=state)).result.result


def load(ask, msg, **fields):
    from simulation_interfaces.srv import LoadWorld

    if hasattr(LoadWorld.Request(), "world_resource"):
        fields = {"world_resource": msg.Resource(**fields)}
    return ask("load_world", **fields)


def test_a_simulator_is_controlled_by_the_standard(start, client, ask, state, become, msg, tmp_path):
    from simulation_interfaces.srv import SetSimulationState

    result, states = msg.Result, msg.SimulationState
    node = start(scenario="undamaged", autostart="false", record__directory=tmp_path)
    features = ask("get_simulator_features").features.features
    assert msg.SimulatorFeatures.STEP_SIMULATION_ACTION in features
    assert msg.SimulatorFeatures.SPAWNING not in features
    assert state() == states.STATE_NO_WORLD
    assert become(states.STATE_PLAYING) == result.RESULT_INCORRECT_STATE
    assert ask("unload_world").result.result == 101
    assert ask("get_current_world").result.result == 101
    assert ask("get_entities").entities == []
    worlds = {world.name: world for world in ask("get_available_worlds").worlds}
    assert worlds["undamaged"].world_resource.uri == "undamaged"
    assert len(worlds["flat_fresh"].description) > 20

    assert load(ask, msg).result.result == 102
    assert load(ask, msg, uri="/etc/passwd").result.result == result.RESULT_NOT_FOUND
    refused = load(ask, msg, resource_string="name: mine\nsped: 20")
    assert (refused.result.result, "did you mean speed?" in refused.result.error_message) == (103, True)
    loaded = load(ask, msg, resource_string=WORLD)
    assert (loaded.result.result, loaded.world.name) == (result.RESULT_OK, "mine"), loaded
    assert state() == states.STATE_STOPPED
    assert client.get("speed", "axle_load") == [20.0, 196200.0]
    assert ask("get_current_world").world.name == "mine"

    assert ask("step_simulation", steps=1500).result.result == result.RESULT_OK
    assert state() == states.STATE_PAUSED
    [name] = ask("get_entities").entities
    assert name == "wheelset_track_sim"
    at = ask("get_entity_state", entity=name).state
    assert (at.pose.position.x, at.twist.linear.x, at.header.frame_id) == (1.5, 20.0, "track")
    assert at.twist.angular.y == pytest.approx(20.0 / 0.4318, rel=0.1)
    assert ask("get_entity_state", entity="nobody").result.result == result.RESULT_NOT_FOUND
    assert ask("get_entities", filters=msg.EntityFilters(filter="w.*_x")).entities == []
    assert ask("get_entity_info", entity=name).info.category.category == msg.EntityCategory.CATEGORY_DYNAMIC_OBJECT
    assert ask("set_entity_state", entity=name).result.result == result.RESULT_FEATURE_UNSUPPORTED

    assert become(states.STATE_PLAYING) == result.RESULT_OK
    assert state() == states.STATE_PLAYING
    assert become(states.STATE_PLAYING) == SetSimulationState.Response.ALREADY_IN_TARGET_STATE
    assert ask("step_simulation", steps=1).result.result == result.RESULT_OPERATION_FAILED
    assert become(states.STATE_PAUSED) == result.RESULT_OK
    assert become(states.STATE_STOPPED) == result.RESULT_OK
    assert state() == states.STATE_STOPPED
    assert become(states.STATE_PAUSED) == result.RESULT_OK
    assert state() == states.STATE_PAUSED
    assert ask("reset_simulation", scope=1).result.result == result.RESULT_FEATURE_UNSUPPORTED
    assert ask("reset_simulation").result.result == result.RESULT_OK

    found, codes = simulate_steps(client, 60_000)
    assert codes == (4, result.RESULT_OK)  # STATUS_SUCCEEDED
    assert found[-1] == (60_000, 0)
    assert all(done + left == 60_000 for done, left in found)

    assert ask("unload_world").result.result == result.RESULT_OK
    assert state() == states.STATE_NO_WORLD
    assert load(ask, msg, uri="damage_wheel_1").result.result == result.RESULT_OK
    assert client.get("wheel_1.damage.h") == [0.002]
    assert become(states.STATE_QUITTING) == result.RESULT_OK
    assert node.wait() == 0, node.errors
    assert "Traceback" not in node.errors


def test_stepping_is_cancelled(start, client, ask, state, msg):
    node = start(scenario="undamaged", autostart="false")
    assert client.transition("configure")
    found, codes = simulate_steps(client, 50_000_000, cancel=True)
    assert codes == (5, msg.Result.RESULT_OPERATION_FAILED)  # STATUS_CANCELED
    assert state() == msg.SimulationState.STATE_PAUSED
    assert found
    end(node)


def simulate_steps(client, steps, *, cancel=False):
    """Feedback of the action; its status and the code of its result."""
    from rclpy.action import ActionClient
    from simulation_interfaces.action import SimulateSteps

    found, done, told = [], threading.Event(), threading.Event()
    results = []

    def hear(message):
        found.append((message.feedback.completed_steps, message.feedback.remaining_steps))
        told.set()

    def accepted(future):
        handle = future.result()
        results.append(handle)
        handle.get_result_async().add_done_callback(lambda answer: (results.append(answer.result()), done.set()))

    action = ActionClient(client.node, SimulateSteps, f"{client.name}/simulate_steps")
    assert action.wait_for_server(60.0)
    action.send_goal_async(SimulateSteps.Goal(steps=steps), hear).add_done_callback(accepted)
    if cancel:
        assert told.wait(60.0)
        results[0].cancel_goal_async()
    assert done.wait(120.0)
    action.destroy()
    return found, (results[1].status, results[1].result.result.result)
