"""1,000 random changes, valid and invalid, by every way, from two clients at once: the node ends where it should."""

import dataclasses
import math
import random
import re
import signal
import threading
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from wheelset_track_sim.bags import Bag, State
from wheelset_track_sim.bags.tread_damage import irregularities_of
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import WHEELS, load_scenario
from wheelset_track_sim.scenario.values import values_of, with_values

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(900)]

CHANGES = 1000
SEEDS = (1, 2)
"""One for each client; which of them comes first is the machine's choice."""
START = load_scenario("undamaged")
SHAPES = ((0.010, 0.008, 0.0005), (0.020, 0.016, 0.001))
ANGLES = (0.0, 1.5, 3.0, 4.5)
BAD = (math.nan, math.inf, -math.inf, -1.0, 1e9)


@dataclasses.dataclass(frozen=True)
class Accepted:
    """An accepted change with the model of it: what it makes of the told scenario, listed damage and parameters."""

    revision: int
    step: int
    make: object
    may_be_idle: bool = False
    """Whether it may change nothing, and then has the revision of the change that did."""


@dataclasses.dataclass(frozen=True)
class Told:
    """What a node was told: parameters show the first breakout of each wheel, and its size when it is taken away."""

    scenario: object
    listed: tuple
    shown: dict


class RandomChanges:
    """Every way to change a run, with what ought to come of it."""

    def __init__(self, client, seed):
        self.client, self.random = client, random.Random(seed)
        self.accepted, self.refused = [], 0

    def run(self, count):
        for _ in range(count):
            self.random.choice((self.damage, self.speed, self.parameters, self.parameters_one_by_one))()

    def number(self, low, high):
        """A number that is good, and whether it is."""
        good = self.random.random() < 0.8
        return (self.random.uniform(low, high), True) if good else (self.random.choice(BAD), False)

    def defect(self, wheel, angle):
        a, b, h = self.random.choice(SHAPES)
        return {"wheel": wheel, "kind": 0, "a": a, "b": b, "h": h, "angle": angle, "y": 0.0}

    def note(self, answer, good, make, quantity, may_be_idle=False):
        assert answer.success == good, answer.message
        if good:
            self.accepted.append(Accepted(answer.revision, answer.step, make, may_be_idle))
        else:
            self.refused += 1
            assert quantity in answer.message
            assert "give" in answer.message

    def damage(self):
        from wheelset_track_msgs.msg import TreadDamage
        from wheelset_track_msgs.srv import SetTreadDamage

        places = self.random.sample([(wheel, angle) for wheel in (1, 2) for angle in ANGLES], self.random.randrange(4))
        damage = [self.defect(*place) for place in places]
        for one in damage:  # no two changes are alike, but to the contact, which counts in steps
            one["angle"] += self.random.uniform(0.0, 1e-4)
        good = not damage or self.random.random() < 0.8
        quantity = self.random.choice(["a", "b", "h", "angle", "y"])
        if not good:
            self.random.choice(damage)[quantity] = self.random.choice(BAD[:3])
        answer = self.client.call(
            "set_tread_damage", SetTreadDamage, again=False, damage=[TreadDamage(**fields) for fields in damage]
        )

        def make(told):
            listed = irregularities_of([SimpleNamespace(**fields) for fields in damage])
            if listed == told.scenario.irregularities:
                return told
            scenario = dataclasses.replace(told.scenario, irregularities=listed)
            return Told(scenario, listed, values_of(scenario))

        self.note(answer, good, make, f".{quantity} = ", may_be_idle=not damage)

    def speed(self):
        from wheelset_track_msgs.srv import SetSpeed

        speed, good = self.number(25.0, 35.0)
        acceleration = self.random.choice((0.0, 5.0, 10.0))
        answer = self.client.call("set_speed", SetSpeed, again=False, speed=speed, acceleration=acceleration)

        def make(told):
            numbers = {"speed": speed, "acceleration": acceleration or told.scenario.acceleration}
            scenario = dataclasses.replace(told.scenario, **numbers)
            return dataclasses.replace(told, scenario=scenario, shown=told.shown | numbers)

        self.note(answer, good, make, "speed = ")

    def parameters(self):
        """Several at once: all or nothing."""
        self.set({**self.of_load(), **self.of_damage()}, atomically=True)

    def parameters_one_by_one(self):
        self.set(self.random.choice((self.of_load, self.of_damage))(), atomically=False)

    def of_load(self):
        load, good = self.number(150e3, 250e3)
        return {"axle_load": (load, good)}

    def of_damage(self):
        wheel = self.random.choice(WHEELS)
        if self.random.random() < 0.2:
            return {f"{wheel}.damage.h": (self.random.choice(BAD), False)}
        return {f"{wheel}.damage.h": (self.random.choice((0.0, 0.001)), True)}

    def set(self, values, atomically):
        from rcl_interfaces.srv import SetParameters, SetParametersAtomically
        from rclpy.parameter import Parameter

        kind, service = SetParameters, "set_parameters"
        if atomically:
            kind, service = SetParametersAtomically, "set_parameters_atomically"
        wanted = [Parameter(name, value=value).to_parameter_msg() for name, (value, _) in values.items()]
        answer = self.client.call(service, kind, again=False, parameters=wanted)
        result = answer.result if atomically else answer.results[0]
        good = all(good for _, good in values.values())
        assert result.successful == good, result.reason
        if not good:
            self.refused += 1
            assert any(name in result.reason for name, (_, good) in values.items() if not good)
        elif result.reason:  # empty if all was so already
            found = re.fullmatch(r"revision (\d+) from step (\d+)", result.reason)

            def make(told):
                shown = told.shown | {name: value for name, (value, _) in values.items()}
                base = dataclasses.replace(told.scenario, irregularities=told.listed)
                return dataclasses.replace(told, scenario=with_values(base, shown), shown=shown)

            self.accepted.append(Accepted(int(found[1]), int(found[2]), make))


def test_the_stream_has_no_gaps_and_the_state_is_that_of_the_last_accepted_change(start, make_client, tmp_path):
    watching = make_client("watching")
    summaries = watching.collect("summary", "LoadSummary")
    states = watching.collect("state", "SimulationState", latched=True)
    bag = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "run"}
    node = start(scenario="undamaged", real_time_factor=4.0, chunk_duration=0.2, acceleration=5.0, **bag)
    watching.until(lambda: summaries and states)
    clients = [RandomChanges(make_client(f"client_{seed}"), seed) for seed in SEEDS]
    failures = []

    def run(one):
        try:
            one.run(CHANGES // len(clients))
        except BaseException as failure:  # noqa: BLE001  told by the test
            failures.append(failure)

    threads = [threading.Thread(target=run, args=[one]) for one in clients]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures

    accepted = [change for one in clients for change in one.accepted]
    accepted.sort(key=lambda change: (change.revision, change.may_be_idle))
    newest = accepted[-1].revision
    assert min(len(one.accepted) for one in clients) > 100
    assert min(one.refused for one in clients) > 50
    start_scenario = dataclasses.replace(START, acceleration=5.0)
    told = Told(start_scenario, (), values_of(start_scenario))
    wanted = {0: told.scenario}
    for change in accepted:
        told = change.make(told)
        wanted[change.revision] = told.scenario
    watching.until(lambda: states[-1].revision == newest)
    shown = dict(zip(values_of(START), watching.get(*values_of(START)), strict=True))
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors

    def assert_told(state):
        """Whether a state is that of its revision, which all accepted ones have led to."""
        expected = wanted[state.revision]
        assert (state.speed_set_point, state.axle_load) == (expected.speed, expected.axle_load)
        damage = [SimpleNamespace(**item) if isinstance(item, dict) else item for item in state.damage]
        assert irregularities_of(damage) == expected.irregularities

    assert_told(states[-1])
    assert shown == told.shown

    for before, after in pairwise(summaries):
        assert after.first_step == before.first_step + before.samples
        assert after.revision >= before.revision
    events = [*Bag(tmp_path / "run").events()]  # which have no gaps
    blocks = [event for event in events if isinstance(event, SampleBlock)]
    recorded = [event for event in events if isinstance(event, State)]
    assert len(recorded) > 100
    for state in recorded:
        assert_told(state)
    revisions = np.array([block.revision for block in blocks])
    assert (np.diff(revisions) >= 0).all()
    assert revisions[-1] == newest
    for change in accepted:  # each at the step that its answer named
        assert blocks[int(np.searchsorted(revisions, change.revision))].first_step == change.step
    told_of = {change.revision for change in accepted} | {0}  # of revision 0 is what changes nothing before all others
    assert told_of == set(range(newest + 1))
