"""Pictures of what a scenario describes, before anything is run: surfaces, profiles, supports, the wheelset."""

from .scenario import show_scenario

__all__ = ["show_scenario"]
