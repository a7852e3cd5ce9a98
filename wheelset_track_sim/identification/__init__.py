"""From a reading to the damage: which damage explains what was measured, and what follows for force and axle."""

from .kind_fits import identify
from .observation import Observation, PeakReading
from .prediction import Prediction, predict
from .results import Identification, Interval, KindFit

__all__ = [
    "Identification",
    "Interval",
    "KindFit",
    "Observation",
    "PeakReading",
    "Prediction",
    "identify",
    "predict",
]
