"""Wheel-rail impact loads and axle stresses of a wheelset with damaged treads on a railway track.

    import wheelset_track_sim as wts

    simulator = wts.Simulator(wts.load_scenario("damage_wheel_1", ["speed=30"]))
    block = simulator.advance(2713)      # one turn of the wheel
    block.forces.max(axis=0)             # N, of wheel 1 and wheel 2

The names in ``__all__`` are the way in for the common jobs; ``docs/reference/api.md`` describes them.

Conventions, once for the whole package (``docs/reference/conventions.md`` explains them):

* SI units and radians everywhere; only text for people shows kN, MPa, km/h and mm.
* x along the track in the running direction, y to the left, z up.
* Wheel 1 is far from the gearbox, wheel 2 next to it; arrays over wheels have that order.
* A contact force is positive in compression. ``xi_w`` is the wheel's displacement away from the rail, ``xi_r`` the
  rail's away from the wheel: both positive under a compressive force, so that Eq. (12) reads as printed.
* One simulation step is one contact element, ``dx = v dt``; step ``i`` is at ``x = i dx``, sleepers at whole bays.
* Frequencies of receptances are in Hz, poles in rad/s, time factor ``exp(+i omega t)``.

The method is that of M. Maglio, A. Pieringer, J. C. O. Nielsen and T. Vernersson, "Wheel-rail impact loads and axle
bending stress simulated for generic distributions and shapes of discrete wheel tread damage"; equation and table
numbers in docstrings are the paper's.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__

if TYPE_CHECKING:
    from .bags import Recording, read_bag
    from .dynamics.moving_green_functions import moving_green_functions
    from .dynamics.responses import green_function, receptance
    from .errors import InputError, InputWarning, WheelsetTrackError
    from .identification import Identification, Observation, PeakReading, Prediction, identify, predict
    from .live.run_messages import record
    from .samples.block import SampleBlock
    from .scenario import Scenario, load_scenario
    from .simulation.fleet import Fleet
    from .simulation.passages import Passages
    from .simulation.simulator import Simulator
    from .studies import Study, load_study, run_study
    from .track.track import load_track
    from .twin import Resimulation, resimulate
    from .wayside.detector import Detector, load_detector
    from .wayside.history import WaysideReading, wayside_reading
    from .wheelset.kinds import load_wheelset
    from .wheelset.vehicle import load_vehicle

_PLACES = {
    "Detector": "wayside.detector",
    "Fleet": "simulation.fleet",
    "Identification": "identification",
    "InputError": "errors",
    "InputWarning": "errors",
    "Observation": "identification",
    "Passages": "simulation.passages",
    "PeakReading": "identification",
    "Prediction": "identification",
    "Recording": "bags",
    "Resimulation": "twin",
    "SampleBlock": "samples.block",
    "Scenario": "scenario",
    "Simulator": "simulation.simulator",
    "Study": "studies",
    "WaysideReading": "wayside.history",
    "WheelsetTrackError": "errors",
    "green_function": "dynamics.responses",
    "identify": "identification",
    "load_detector": "wayside.detector",
    "load_scenario": "scenario",
    "load_study": "studies",
    "load_track": "track.track",
    "load_vehicle": "wheelset.vehicle",
    "load_wheelset": "wheelset.kinds",
    "moving_green_functions": "dynamics.moving_green_functions",
    "predict": "identification",
    "read_bag": "bags",
    "receptance": "dynamics.responses",
    "record": "live.run_messages",
    "resimulate": "twin",
    "run_study": "studies",
    "wayside_reading": "wayside.history",
}

__all__ = [
    "Detector",
    "Fleet",
    "Identification",
    "InputError",
    "InputWarning",
    "Observation",
    "Passages",
    "PeakReading",
    "Prediction",
    "Recording",
    "Resimulation",
    "SampleBlock",
    "Scenario",
    "Simulator",
    "Study",
    "WaysideReading",
    "WheelsetTrackError",
    "__version__",
    "green_function",
    "identify",
    "load_detector",
    "load_scenario",
    "load_study",
    "load_track",
    "load_vehicle",
    "load_wheelset",
    "moving_green_functions",
    "predict",
    "read_bag",
    "receptance",
    "record",
    "resimulate",
    "run_study",
    "wayside_reading",
]


def __getattr__(name: str) -> Any:
    """Import a name of the front door when it is first used: the package itself is imported in milliseconds."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
