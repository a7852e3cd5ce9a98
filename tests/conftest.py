"""What all tests share: skips by name, profiles of hypothesis, and thin fixtures of what tests/support has."""

from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path

import pytest

from support.blocks import RUN_INFO, block_of_numbers, small_run, state_of_numbers
from support.toy import toy_simulator
from wheelset_track_sim.bags import RunInfo, State
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.simulation.simulator import Simulator

try:
    from hypothesis import settings
except ModuleNotFoundError:  # as in a workspace without it: its tests are skipped by name
    pass
else:
    # The first example may compile a kernel, and machines are shared: no test is about seconds. All tests together try
    # the same examples every time, so that what passes passes again; `make check` tries others each time, `make search`
    # many.
    settings.register_profile("same", deadline=None, derandomize=True)
    settings.register_profile("quick", deadline=None, max_examples=20)
    settings.register_profile("search", deadline=None, max_examples=2000)
    settings.register_profile("fuzz", deadline=None, max_examples=10_000)
    settings.load_profile("same")


OPTIONAL = {"hypothesis", "mcap_ros2", "yaml"}
"""Modules that tests import at their beginning and that no dependency of the package brings."""
EXPENSIVE = {"reduced_x40", "ring", "reduced"}
"""Fixtures that build models of many finite elements; what uses them is slow, whichever case comes first."""


class Module(pytest.Module):
    """A file of tests that is skipped by name if it needs what is not installed."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        try:
            return super().collect()
        except self.CollectError as failure:
            missing = getattr(failure.__cause__, "name", None)
            if isinstance(failure.__cause__, ModuleNotFoundError) and missing in OPTIONAL:
                pytest.skip(f"needs {missing}: make test brings it", allow_module_level=True)
            raise


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module:
    module: pytest.Module = Module.from_parent(parent, path=module_path)
    return module


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if isinstance(item, pytest.Function) and EXPENSIVE.intersection(item.fixturenames):
            item.add_marker(pytest.mark.slow)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what needs ROS where there is none. It is looked for and not imported, so that collecting stays quick."""
    for name in ("rclpy", "wheelset_track_msgs") if item.get_closest_marker("ros") else ():
        if find_spec(name) is None:
            pytest.skip(f"{name} is not installed: make setup brings it")


@pytest.fixture(scope="session")
def make_small_run() -> Callable[..., tuple[list[SampleBlock], list[State], RunInfo]]:
    return small_run


@pytest.fixture
def make_block() -> Callable[..., SampleBlock]:
    return block_of_numbers


@pytest.fixture
def make_state() -> Callable[[SampleBlock], State]:
    return state_of_numbers


@pytest.fixture
def run_info() -> RunInfo:
    return RUN_INFO


@pytest.fixture
def run_blocks() -> list[SampleBlock]:
    """Three gap-free blocks of different length; the last has another speed and revision."""
    first = block_of_numbers(0, 1389)
    second = block_of_numbers(1389, 1, time=1389 * first.step_period)
    third = block_of_numbers(1390, 700, time=1390 * first.step_period, speed=1e3 / 36, revision=1)
    return [first, second, third]


@pytest.fixture
def smooth() -> Simulator:
    return toy_simulator()


@pytest.fixture
def damaged() -> Simulator:
    return toy_simulator(like="damage_wheel_1")
