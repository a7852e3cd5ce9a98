"""What `make fuzz` says of each kind of input: how much was tried, and what took the longest and the most memory."""

from collections.abc import Iterator

import pytest

from support.mutants import FIGURES, MUTANTS

MANY = 1000
"""Mutants from which on the figures are worth a table."""


@pytest.fixture(autouse=True)
def figures(record_property: object, request: pytest.FixtureRequest) -> Iterator[None]:
    FIGURES.clear()
    yield
    request.node.user_properties.extend(FIGURES.items())


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    reports = [each for kind in terminalreporter.stats.values() for each in kind if hasattr(each, "when")]
    told = [(each.nodeid, dict(each.user_properties)) for each in reports if each.when == "teardown"]
    if MUTANTS < MANY or not told:
        return
    terminalreporter.section(f"{MUTANTS} mutants of each kind")
    for name, of in told:
        if "operations" in of:
            most = f"slowest {of['slowest']:5.2f} s, largest {of['largest'] / 1e6:5.0f} MB"
            terminalreporter.line(f"{of['operations']:>8.0f} operations, {most}  {name}")
