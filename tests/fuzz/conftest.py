"""What `make fuzz` says of each kind of input: how much was tried, and what took the longest and the most memory.

``support.mutants`` asks for the profile of Hypothesis, which is loaded after this file: it is imported when needed.
"""

from collections.abc import Iterator

import pytest

MANY = 1000
"""Mutants from which on the figures are worth a table."""


@pytest.fixture(autouse=True)
def figures(record_property: object, request: pytest.FixtureRequest) -> Iterator[None]:
    from support.mutants import FIGURES

    FIGURES.clear()
    yield
    request.node.user_properties.extend(FIGURES.items())


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    from support.mutants import MUTANTS

    reports = [each for kind in terminalreporter.stats.values() for each in kind if hasattr(each, "when")]
    told = [(each.nodeid, dict(each.user_properties)) for each in reports if each.when == "teardown"]
    if MUTANTS < MANY or not told:
        return
    terminalreporter.section(f"{MUTANTS} mutants of each kind")
    for name, of in told:
        if "operations" in of:
            most = f"slowest {of['slowest']:5.2f} s, largest {of['largest'] / 1e6:5.0f} MB"
            terminalreporter.line(f"{of['operations']:>8.0f} operations, {most}  {name}")
