"""Real nodes as real processes over the real middleware, each test in a ROS domain of its own."""

import os
import signal
import socket
import threading
from contextlib import ExitStack

import pytest

from support.nodes import Client, NodeProcess, end


@pytest.fixture
def domain():
    """ROS domain that nobody else on this machine uses: an abstract socket holds it until the test ends."""
    for number in range(1, 100):
        holder = socket.socket(socket.AF_UNIX)
        try:
            holder.bind(f"\0wheelset_track_sim_domain_{number}")
        except OSError:
            holder.close()
            continue
        with holder:
            yield number
        return
    pytest.fail("no ROS domain is free")


@pytest.fixture
def running():
    """Nodes that the test has started."""
    return []


@pytest.fixture
def start(domain, tmp_path, running):
    """Start a node: parameters by name, with ``__`` for a dot."""
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_PYTHON_CHECK_FIELDS": "1",
        "PYTHONFAULTHANDLER": "1",
        "ROS_LOG_DIR": str(tmp_path / "log"),
    }
    with ExitStack() as stack:

        def start(*arguments, env=None, program="node", **parameters):
            named = {name.replace("__", "."): value for name, value in parameters.items()}
            node = NodeProcess(environment | (env or {}), named, arguments, program)
            running.append(node)
            stack.callback(node.close)
            stack.callback(end, node.process)
            return node

        yield start


@pytest.fixture
def make_client(domain, running, monkeypatch):
    """Make a client: each has a context, an executor and a thread of its own, as another process would."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.task import Future

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with ExitStack() as stack:

        def make(name="client", **options):
            context = rclpy.Context()
            rclpy.init(context=context, domain_id=domain)
            stack.callback(context.shutdown)
            node = rclpy.create_node(name, context=context, **options)
            stack.callback(node.destroy_node)
            executor = SingleThreadedExecutor(context=context)
            stack.callback(executor.shutdown)
            executor.add_node(node)
            done = Future()
            thread = threading.Thread(target=executor.spin_until_future_complete, args=[done])
            thread.start()
            stack.callback(thread.join)
            stack.callback(done.set_result, None)
            return Client(node, running)

        yield make


@pytest.fixture
def client(make_client):
    return make_client()


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
def stop_signal(request):
    return request.param


@pytest.fixture
def short_bag(tmp_path, run_info, run_blocks, make_state):
    """A bag with a message on each topic of a run."""
    from wheelset_track_sim.bags import BagWriter
    from wheelset_track_sim.bags.messages import impact_message
    from wheelset_track_sim.samples.impacts import Impact

    path = tmp_path / "short.mcap"
    with BagWriter(path, run_info, start_ns=1_700_000_000 * 10**9) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks:
            writer.write(block)
        numbers = dict.fromkeys(Impact.__dataclass_fields__, 1.0) | {"step": 9, "revision": 0, "wheel": 0}
        writer.write_messages([impact_message(Impact(**numbers), writer.start_ns)])
    return path


@pytest.fixture
def services(client):
    from support.service_calls import Services

    return Services(client)


@pytest.fixture
def summaries(client):
    return client.collect("summary", "LoadSummary")


@pytest.fixture
def forces(client):
    return client.collect("contact_forces", "ContactForces")


@pytest.fixture
def states(client):
    return client.collect("state", "SimulationState", latched=True)


@pytest.fixture
def reports(client):
    """Levels and messages of the simulation on /diagnostics."""
    from diagnostic_msgs.msg import DiagnosticArray

    found = []

    def take(message):
        with client.arrived:
            found.extend(
                (item.level[0], item.message)
                for item in message.status
                if item.name == "wheelset_track_sim: simulation"
            )
            client.arrived.notify_all()

    client.node.create_subscription(DiagnosticArray, "/diagnostics", take, 100)
    return found
