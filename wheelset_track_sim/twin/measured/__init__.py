"""Measured loads and stresses: read, put on one axis with a simulation, compared with it."""

from .comparison import Comparison, Matching, compare
from .measurement import Measurement
from .reading import Reading, read_measurement

__all__ = ["Comparison", "Matching", "Measurement", "Reading", "compare", "read_measurement"]
