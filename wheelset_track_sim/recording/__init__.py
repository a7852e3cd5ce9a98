"""Runs as MCAP bags: written and read without ROS."""

from .bag_reader import Bag
from .bag_writer import BagWriter
from .messages import State
from .recording import Recording, blocks, read
from .run_info import RunInfo
from .settings import RecordSettings

__all__ = ["Bag", "BagWriter", "RecordSettings", "Recording", "RunInfo", "State", "blocks", "read"]
