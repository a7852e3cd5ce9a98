"""What is simulated: read whole, typed and checked when it is loaded."""

from .contact import ContactOptions
from .events import Event, Growth
from .loading import assign, change_of, find_beside, load_scenario, override, scenario_from, suspect, take_in
from .loads import Loads
from .profiles import Profiles
from .scenario import WHEELS, Output, Scenario, SetPoint

__all__ = [
    "WHEELS",
    "ContactOptions",
    "Event",
    "Growth",
    "Loads",
    "Output",
    "Profiles",
    "Scenario",
    "SetPoint",
    "assign",
    "change_of",
    "find_beside",
    "load_scenario",
    "override",
    "scenario_from",
    "suspect",
    "take_in",
]
