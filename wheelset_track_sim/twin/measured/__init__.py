"""Measured loads and stresses: read, put on one axis with a simulation, compared with it."""

from .comparison import Comparison, Matching, compare
from .csv_file import read_csv
from .measurement import Measurement

__all__ = ["Comparison", "Matching", "Measurement", "compare", "read_csv"]
