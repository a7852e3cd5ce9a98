"""Wheel-rail normal contact: influence coefficients, Kalker's variational method, Hertz, force tables.

The coupled step calls ``contact_force`` of ``law_kernels`` with the law that ``build_contact_law`` makes.
"""

from .geometry import ContactGeometry, ProfilePair
from .hertz import HertzContact
from .law import build_contact_law
from .law_kernels import ContactLaw, contact_force
from .profiles import Points, RailHead, Straight
from .solutions import ContactPatch, approach_for_force, force_at, solve_patch

__all__ = [
    "ContactGeometry",
    "ContactLaw",
    "ContactPatch",
    "HertzContact",
    "Points",
    "ProfilePair",
    "RailHead",
    "Straight",
    "approach_for_force",
    "build_contact_law",
    "contact_force",
    "force_at",
    "solve_patch",
]
