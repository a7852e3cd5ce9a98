"""What all benchmarks share: one core, rounds that add up to little, real-time factors, a machine without a name."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from typing import Any

import numba
import numpy as np
import pytest
from llvmlite import binding

Measure = Callable[..., float]


def group(name: str) -> pytest.MarkDecorator:
    """Mark of benchmarks that stand in one table; timed by the processor, so that other programs do not count."""
    return pytest.mark.benchmark(group=name, timer=time.process_time)


def pytest_configure(config: pytest.Config) -> None:
    """Know our mark."""
    config.addinivalue_line("markers", "all_cores: is not held on one core")


@pytest.hookimpl(optionalhook=True)
def pytest_benchmark_update_machine_info(config: pytest.Config, machine_info: dict[str, Any]) -> None:
    """Keep what bears on speed; the name of the machine is nobody's business."""
    cpu = machine_info.get("cpu", {})
    kept = {name: cpu.get(name) for name in ("brand_raw", "arch", "count", "l2_cache_size", "l3_cache_size")}
    versions = {"python": machine_info.get("python_version"), "numpy": np.__version__, "numba": numba.__version__}
    machine_info.clear()
    machine_info.update({"cpu": kept | {"target": str(binding.get_host_cpu_name())}, "versions": versions})


@pytest.fixture(autouse=True)
def one_core(request: pytest.FixtureRequest) -> Iterator[None]:
    """Held on one core, the last, where the rest of the machine is least busy."""
    if request.node.get_closest_marker("all_cores") or not hasattr(os, "sched_setaffinity"):
        yield
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    yield
    os.sched_setaffinity(0, cores)


@pytest.fixture
def measure(benchmark: Any) -> Measure:
    """``measure(function, simulated=s, rounds=n, **facts)``: best time of a call, s; keeps the real-time factor."""

    def run(function: Callable[[], Any], *, simulated: float = 0.0, rounds: int = 10, **facts: Any) -> float:
        benchmark.pedantic(function, rounds=rounds, warmup_rounds=1)
        best = float(benchmark.stats.stats.min)
        if simulated:
            benchmark.extra_info["simulated_s"] = simulated
            benchmark.extra_info["real_time_factor"] = simulated / best
        benchmark.extra_info.update(facts)
        return best

    return run


@pytest.fixture
def record(benchmark: Any) -> Measure:
    """``record(function)``: call once a function that measures by itself; keeps the numbers that it returns."""

    def run(function: Callable[[], dict[str, Any]], **facts: Any) -> float:
        found = benchmark.pedantic(function, rounds=1)
        benchmark.extra_info.update(found | facts)
        return float(benchmark.stats.stats.min)

    return run
