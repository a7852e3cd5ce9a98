"""Runs as MCAP bags: written and read without ROS."""

from .bag import Bag
from .bag_writer import BagWriter
from .losses import Damage, Gap, Loss
from .messages import State
from .run_arrays import Recording, blocks, read_bag
from .run_info import RunInfo
from .settings import RecordSettings

__all__ = [
    "Bag",
    "BagWriter",
    "Damage",
    "Gap",
    "Loss",
    "RecordSettings",
    "Recording",
    "RunInfo",
    "State",
    "blocks",
    "read_bag",
]
