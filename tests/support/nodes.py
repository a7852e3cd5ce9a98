"""A node in a process of its own, and another process's view of it over the real middleware."""

import signal
import subprocess
import sys
import tempfile
import threading
import time

import pytest

PATIENCE = 240.0
"""Bound on every wait, s: on a fresh machine the models are built first."""
ANSWER = 60.0
"""Bound on the answer of a service, s: the first change on a fresh machine compiles the contact solver."""
PROMPT = 60.0
"""Bound on the end of a node that was told to end, s: a stage of building models is not broken off."""


class NodeProcess:
    """``wheelset-track-sim node``, or another program of it, in a process of its own."""

    def __init__(self, environment, parameters, arguments=(), program="node"):
        command = [sys.executable, "-m", "wheelset_track_sim", program, *map(str, arguments)]
        given = [item for name, value in parameters.items() for item in ("-p", f"{name}:={value}")]
        if given:
            command += ["--ros-args", *given]
        self.ended = False
        """Whether the test knows that it has ended."""
        # Files and not pipes: a node that logs every change would fill a pipe that nobody reads, and stand still.
        self._written = [tempfile.TemporaryFile("w+", encoding="utf-8") for _ in range(2)]  # noqa: SIM115  see close
        out, errors = self._written
        self.process = subprocess.Popen(command, env=environment, stdout=out, stderr=errors, start_new_session=True)

    def signal(self, number):
        """Exit status after a signal."""
        self.process.send_signal(number)
        return self.wait(PROMPT)

    def wait(self, timeout=PATIENCE):
        """Exit status; ``output`` and ``errors`` hold what was written."""
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGABRT)  # the fault handler tells where it hangs
            self.process.wait()
            pytest.fail("the node did not end:\n" + "\n".join(self._read()))
        self.output, self.errors = self._read()
        self.ended = True
        return self.process.returncode

    def _read(self):
        texts = []
        for file in self._written:
            file.seek(0)
            texts.append(file.read())
        return texts

    def close(self):
        """Forget what was written."""
        for file in self._written:
            file.close()


def end(process):
    """Orderly, for a process that is killed leaves shared memory of the middleware behind."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
    try:
        process.communicate(timeout=PROMPT)  # closes its pipes, also of one that has ended
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()


class Client:
    """Another process's view of the node: subscriptions and service calls."""

    name = "/wheelset_track_sim"
    goals = {  # noqa: RUF012
        "configure": "inactive",
        "activate": "active",
        "deactivate": "inactive",
        "cleanup": "unconfigured",
        "shutdown": "finalized",
    }

    def __init__(self, node, running):
        self.node, self.running = node, running
        self.arrived = threading.Condition()
        self.clients = {}

    def collect(self, topic, kind, latched=False):
        """List that fills with the messages of a topic."""
        import wheelset_track_msgs.msg
        from rclpy.qos import DurabilityPolicy, QoSProfile

        found = []

        def take(message):
            with self.arrived:
                found.append(message)
                self.arrived.notify_all()

        quality = QoSProfile(
            depth=500, durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        )
        self.node.create_subscription(getattr(wheelset_track_msgs.msg, kind), f"{self.name}/{topic}", take, quality)
        return found

    def until(self, condition):
        """Wait until a condition on what was collected holds."""
        limit = time.monotonic() + PATIENCE
        while not self.hears(condition):
            self.check_nodes()
            assert time.monotonic() < limit, "it did not come true in time"

    def hears(self, condition):
        """Whether a condition on what was collected comes true within a second."""
        with self.arrived:
            return self.arrived.wait_for(condition, 1.0)

    def check_nodes(self):
        for node in self.running:
            if not node.ended and node.process.poll() is not None:
                pytest.fail(f"the node ended with status {node.wait()}: {node.errors}")

    def call(self, service, kind, again=True, **fields):
        """Answer of a service of the node.

        The middleware loses the answer to a client that the node has not discovered yet, so a new client waits until
        the node answers another one. ``again`` asks again when an answer is lost all the same; otherwise it is None.
        """
        if service not in self.clients:
            self.clients[service] = self.node.create_client(kind, f"{self.name}/{service}")
            if self.name:  # that of a node, which has this service
                self.meet()
        asked = self.ask(self.clients[service], kind.Request(**fields), ANSWER, again)
        assert asked or not again, f"{service} did not answer"
        return asked[0] if asked else None

    def meet(self):
        """Wait until the node knows all clients made so far: it learns of them in the order in which they were made."""
        from rcl_interfaces.srv import GetParameters

        newest = self.node.create_client(GetParameters, f"{self.name}/get_parameters")
        assert self.ask(newest, GetParameters.Request(), 1.0, again=True), "the node did not answer"

    def ask(self, client, request, patience, again):
        """The answer of a service, or nothing; ``again`` asks again each time that ``patience`` is over."""
        limit = time.monotonic() + PATIENCE
        while not client.wait_for_service(1.0):
            self.check_nodes()
            assert time.monotonic() < limit, f"there is no service {client.srv_name}"
        while time.monotonic() < limit:
            answered = threading.Event()
            future = client.call_async(request)
            future.add_done_callback(lambda _, answered=answered: answered.set())
            if answered.wait(patience):
                return [future.result()]
            self.check_nodes()
            client.remove_pending_request(future)
            if not again:
                break
        return []

    def trigger(self, service):
        """Answer of a service without arguments."""
        from std_srvs.srv import Trigger

        return self.call(service, Trigger, again=False)

    def transition(self, label):
        """Whether a transition succeeded."""
        from lifecycle_msgs.msg import Transition
        from lifecycle_msgs.srv import ChangeState

        answer = self.call("change_state", ChangeState, again=False, transition=Transition(label=label))
        return self.state() == self.goals[label] if answer is None else answer.success

    def state(self):
        from lifecycle_msgs.srv import GetState

        return self.call("get_state", GetState).current_state.label

    def wait_for_state(self, label):
        until = time.monotonic() + PATIENCE
        while (found := self.state()) != label:
            assert time.monotonic() < until, f"the node is {found}, not {label}"
            time.sleep(0.05)

    def set(self, atomically=False, **values):
        """Answers to setting parameters."""
        from rcl_interfaces.srv import SetParameters, SetParametersAtomically
        from rclpy.parameter import Parameter

        wanted = [Parameter(name.replace("__", "."), value=value).to_parameter_msg() for name, value in values.items()]
        if atomically:
            return self.call("set_parameters_atomically", SetParametersAtomically, parameters=wanted).result
        [result] = self.call("set_parameters", SetParameters, parameters=wanted).results
        return result

    def get(self, *names):
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        return [
            parameter_value_to_python(value) for value in self.call("get_parameters", GetParameters, names=names).values
        ]
