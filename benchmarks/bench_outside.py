"""What has a program of its own beside this file: bags, node, memory over an hour, fleet, roughness."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import pytest

from benchmarks import fleet
from benchmarks.bag_throughput import bag_throughput
from benchmarks.conftest import Measure
from benchmarks.memory import Memory, memory_of_node, memory_of_run
from benchmarks.node_throughput import node_load, node_throughput

HOUR = 3600.0


@pytest.fixture
def ros() -> None:
    """Skip where there is no ROS 2."""
    pytest.importorskip("rclpy", exc_type=ImportError)


@pytest.mark.benchmark(group="bag")
def test_bag(record: Measure) -> None:
    """Written and read, signals with all eighteen components busy."""
    record(bag_throughput)


@pytest.mark.all_cores
@pytest.mark.benchmark(group="node")
@pytest.mark.usefixtures("ros")
@pytest.mark.parametrize(
    ("subscriber", "scenario"),
    [(False, "damage_wheel_1"), (True, "damage_wheel_1"), (False, "rough_wheel")],
    ids=["alone", "with a subscriber", "rough wheels"],
)
def test_node(record: Measure, subscriber: bool, scenario: str) -> None:
    """One core for the node, publishing everything and recording; a subscriber has the other. The best of three."""
    runs = [node_throughput(subscriber=subscriber, scenario=scenario) for _ in range(3)]
    record(lambda: {key: (min if key.endswith("_s") else max)(run[key] for run in runs) for key in runs[0]})


@pytest.mark.all_cores
@pytest.mark.benchmark(group="rates")
@pytest.mark.usefixtures("ros")
@pytest.mark.parametrize("subscribers", [0, 1, 4])
@pytest.mark.parametrize("rate", [10, 20, 100])
def test_rate(record: Measure, rate: int, subscribers: int) -> None:
    """Share of a core that a node in real time takes with chunks at a rate, Hz; subscribers take in all topics."""
    record(lambda: {"share_of_core": node_load(rate, subscribers)}, rate=rate, subscribers=subscribers)


@pytest.mark.all_cores
@pytest.mark.benchmark(group="memory")
@pytest.mark.parametrize("scenario", ["damage_wheel_1", "rough_wheel"])
def test_memory_of_run(record: Measure, scenario: str) -> None:
    """An hour in memory."""
    record(lambda: _of_memory(memory_of_run(HOUR, scenario=scenario)))


@pytest.mark.all_cores
@pytest.mark.benchmark(group="memory")
@pytest.mark.usefixtures("ros")
def test_memory_of_node(record: Measure) -> None:
    """An hour, everything published."""
    record(lambda: _of_memory(memory_of_node(HOUR)))


def _of_memory(found: Memory) -> dict[str, Any]:
    later = found.after(60.0)
    return {
        "simulated_s": asdict(found)["simulated"],
        "spread": found.spread,
        "least_mb": min(later),
        "most_mb": max(later),
    }


@pytest.mark.all_cores
@pytest.mark.benchmark(group="fleet")
@pytest.mark.parametrize("wheelsets", [1, 8, 32])
def test_fleet(record: Measure, wheelsets: int) -> None:
    """Wheelsets in real time on two cores, in memory."""
    record(lambda: {"in_real_time": fleet.library(wheelsets)}, wheelsets=wheelsets)


@pytest.mark.benchmark(group="fleet")
@pytest.mark.parametrize("wheelsets", [8, 32])
def test_cost_of_a_fleet(record: Measure, wheelsets: int) -> None:
    """Time of the processor for some wheelsets over so many times that for one."""
    record(lambda: {"ratio": fleet.library_cost([wheelsets])[0]}, wheelsets=wheelsets)


@pytest.mark.all_cores
@pytest.mark.benchmark(group="fleet")
@pytest.mark.usefixtures("ros")
@pytest.mark.parametrize("wheelsets", [8])
def test_fleet_of_nodes(record: Measure, wheelsets: int) -> None:
    """Time of the processor that a node of a fleet takes, everything published."""
    record(lambda: {"share_of_core": fleet.node_cost(wheelsets)}, wheelsets=wheelsets)


@pytest.mark.benchmark(group="roughness")
def test_rough(record: Measure) -> None:
    """Both treads and rails rough, contacts solved in every step."""
    record(pytest.importorskip("rough_wheels").rough_wheels)
