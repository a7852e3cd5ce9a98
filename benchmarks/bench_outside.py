"""What has a program of its own beside this file: bags, node, memory over an hour, fleet, roughness."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import fleet
import pytest
from bag_throughput import bag_throughput
from conftest import Measure
from memory import Memory, memory_of_node, memory_of_run
from node_throughput import node_throughput

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
@pytest.mark.parametrize("subscriber", [False, True], ids=["alone", "with a subscriber"])
def test_node(record: Measure, subscriber: bool) -> None:
    """One core for the node, publishing everything and recording; a subscriber has the other."""
    record(lambda: node_throughput(subscriber=subscriber))


@pytest.mark.all_cores
@pytest.mark.benchmark(group="memory")
def test_memory_of_run(record: Measure) -> None:
    """An hour in memory."""
    record(lambda: _of_memory(memory_of_run(HOUR)))


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
def test_cost_of_a_fleet(record: Measure) -> None:
    """Time of 32 wheelsets over 32 times that of one."""
    record(lambda: {"ratio": fleet.library_cost([32])[0]}, wheelsets=32)


@pytest.mark.all_cores
@pytest.mark.benchmark(group="fleet")
@pytest.mark.usefixtures("ros")
@pytest.mark.parametrize("wheelsets", [1, 8])
def test_fleet_of_nodes(record: Measure, wheelsets: int) -> None:
    """The same by nodes in one process, everything published."""
    record(lambda: {"in_real_time": fleet.nodes(wheelsets)}, wheelsets=wheelsets)
