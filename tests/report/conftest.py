"""Surveys and bags of plain numbers, and the page of a run where bokeh is installed."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def make_survey() -> Callable[..., Any]:
    from support.surveys import survey_of_numbers

    return survey_of_numbers


@pytest.fixture(scope="session")
def make_bag() -> Callable[..., Path]:
    from support.surveys import bag_of_numbers

    return bag_of_numbers


@pytest.fixture(scope="session")
def write_report() -> Callable[..., Path]:
    """Function that writes a page: it imports bokeh, which takes half a second."""
    pytest.importorskip("bokeh", reason="the page needs the extra report")
    from wheelset_track_sim.report.page import write_report

    return write_report
