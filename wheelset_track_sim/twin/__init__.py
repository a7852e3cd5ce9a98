"""A recorded run and the model side by side: simulated again from its inputs, as it was or with other settings."""

from .resimulation import Resimulation, resimulate

__all__ = ["Resimulation", "resimulate"]
