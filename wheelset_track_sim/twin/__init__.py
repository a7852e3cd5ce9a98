"""A recorded run beside the model: simulated again from what went in, as it was or with something changed."""

from .resimulation import Again, simulate_again

__all__ = ["Again", "simulate_again"]
