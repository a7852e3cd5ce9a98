"""A process that asks a running node for anything, at random: python -m support.random_client SEED SECONDS.

Each accepted speed is printed, as JSON on a line of its own, with the revision and the step of its answer. A call that
is not answered, and an answer that no node may give, end the process with a traceback.
"""

import json
import math
import random
import re
import sys
import threading
import time

from support.nodes import Client

TRANSITIONS = ("configure", "activate", "deactivate", "cleanup")
BAD = (math.nan, math.inf, -1.0, 1e9)
NAME = re.compile(r"revision (\d+) from step (\d+)")


class RandomClient:
    """Calls of every kind; those that stop the run are rare, or nothing else would happen."""

    def __init__(self, client, seed):
        self.client, self.random = client, random.Random(seed)
        self.calls = {}

    def run(self, seconds):
        kinds = {
            self.set_speed: 8,
            self.set_parameter: 8,
            self.command_speed: 4,
            self.set_irregularities: 2,
            self.read_parameters: 4,
            self.ask_for_the_pressure: 2,
            self.record: 3,
            self.pause_or_resume: 3,
            self.change_state: 2,
            self.reset: 1,
        }
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            [kind] = self.random.choices([*kinds], [*kinds.values()])
            kind()
            self.calls[kind.__name__] = self.calls.get(kind.__name__, 0) + 1

    def called(self, service, kind, **fields):
        answer = self.client.call(service, kind, again=False, **fields)
        assert answer is not None, f"{service} was not answered"
        told = getattr(answer, "message", "")
        assert "it failed" not in told, f"{service}: {told}"
        assert getattr(answer, "success", True) or told or service == "change_state", (
            f"{service}: refused without a reason"
        )
        return answer

    def speed(self):
        """A speed that nobody else asks for, or one that is refused."""
        return self.random.choice(BAD) if self.random.random() < 0.2 else self.random.uniform(20.0, 35.0)

    def accepted(self, speed, revision, step):
        print(json.dumps({"speed": speed, "revision": revision, "step": step}), flush=True)

    def set_speed(self):
        from wheelset_track_msgs.srv import SetSpeed

        speed = self.speed()
        answer = self.called("set_speed", SetSpeed, speed=speed, acceleration=5.0)
        assert answer.success == (20.0 <= speed <= 35.0) or "busy" in answer.message, answer.message
        if answer.success:
            self.accepted(speed, answer.revision, answer.step)

    def set_parameter(self):
        from rcl_interfaces.srv import SetParameters, SetParametersAtomically
        from rclpy.parameter import Parameter

        name = self.random.choice(["speed", "axle_load", "wheel_1.damage.h", "real_time_factor", "no_such_parameter"])
        values = {"speed": self.speed(), "axle_load": self.random.uniform(150e3, 250e3), "wheel_1.damage.h": 0.0005}
        value = values.get(name, self.random.uniform(0.5, 2.0))
        wanted = [Parameter(name, value=value).to_parameter_msg()]
        if self.random.random() < 0.5:
            result = self.called("set_parameters_atomically", SetParametersAtomically, parameters=wanted).result
        else:
            [result] = self.called("set_parameters", SetParameters, parameters=wanted).results
        assert result.successful or result.reason
        found = NAME.fullmatch(result.reason)
        if name == "speed" and result.successful and found:
            self.accepted(value, int(found[1]), int(found[2]))

    def command_speed(self):
        from std_msgs.msg import Float64

        if "cmd" not in self.client.clients:
            self.client.clients["cmd"] = self.client.node.create_publisher(Float64, f"{self.client.name}/cmd/speed", 1)
        self.client.clients["cmd"].publish(Float64(data=self.speed()))

    def set_irregularities(self):
        from wheelset_track_msgs.srv import SetIrregularities

        text = self.random.choice(
            ["[]", "[{type: breakout", "[{type: no_such}]", "[{type: wheel_flat, on: wheel_1, length: 0.02}]"]
        )
        self.called("set_irregularities", SetIrregularities, irregularities=text)

    def read_parameters(self):
        from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters

        self.called("list_parameters", ListParameters)
        names = self.random.sample(["speed", "axle_load", "scenario", "nothing"], 2)
        self.called("get_parameters", GetParameters, names=names)
        self.called("describe_parameters", DescribeParameters, names=names)

    def ask_for_the_pressure(self):
        from wheelset_track_msgs.srv import GetContactPressure

        self.called(
            "get_contact_pressure", GetContactPressure, wheel=self.random.randrange(4), at=self.random.randrange(3)
        )

    def record(self):
        from wheelset_track_msgs.srv import StartRecording

        if self.random.random() < 0.5:
            self.called("start_recording", StartRecording)
        else:
            self.trigger(self.random.choice(["stop_recording", "split_recording", "take_snapshot"]))

    def trigger(self, service):
        from std_srvs.srv import Trigger

        self.called(service, Trigger)

    def pause_or_resume(self):
        self.trigger(self.random.choice(["pause", "resume", "resume"]))

    def reset(self):
        self.trigger("reset")

    def change_state(self):
        from lifecycle_msgs.msg import Transition
        from lifecycle_msgs.srv import ChangeState, GetState

        self.called("get_state", GetState)
        label = self.random.choice(TRANSITIONS)
        self.called("change_state", ChangeState, transition=Transition(label=label))
        if label in ("cleanup", "deactivate"):  # up again, whatever the others do meanwhile
            for back in ("configure", "activate"):
                self.called("change_state", ChangeState, transition=Transition(label=back))


def main(seed, seconds):
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.task import Future

    rclpy.init()
    node = rclpy.create_node(f"random_client_{seed}")
    executor, done = SingleThreadedExecutor(), Future()
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin_until_future_complete, args=[done])
    thread.start()
    try:
        one = RandomClient(Client(node, []), seed)
        one.run(seconds)
        print(json.dumps({"calls": one.calls}), flush=True)
    finally:
        done.set_result(None)
        thread.join()
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown()


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]))
