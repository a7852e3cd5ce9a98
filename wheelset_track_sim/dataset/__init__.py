"""Labelled data sets: signals of wheelsets with drawn damage, in Zarr, with labels and a card."""

from .spec import DatasetSpec, load_spec
from .writing import rebuild, write_dataset

__all__ = ["DatasetSpec", "load_spec", "rebuild", "write_dataset"]
