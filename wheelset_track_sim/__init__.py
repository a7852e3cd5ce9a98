"""Wheel-rail impact loads and axle stresses of a wheelset with damaged treads on a railway track.

Conventions, once for the whole package (``docs/conventions.md`` explains them):

* SI units and radians everywhere; only text for people shows kN, MPa, km/h and mm.
* x along the track in the running direction, y to the left, z up.
* Wheel 1 is far from the gearbox, wheel 2 next to it; arrays over wheels have that order.
* A contact force is positive in compression. ``xi_w`` is the wheel's displacement away from the rail, ``xi_r`` the
  rail's away from the wheel: both positive under a compressive force, so that Eq. (12) reads as printed.
* One simulation step is one contact element, ``dx = v dt``; step ``i`` is at ``x = i dx``, sleepers at whole bays.
* Frequencies of receptances are in Hz, poles in rad/s, time factor ``exp(+i omega t)``.

The method is that of M. Maglio, A. Pieringer, J. C. O. Nielsen and T. Vernersson, "Wheel-rail impact loads and axle
bending stress simulated for generic distributions and shapes of discrete wheel tread damage"; equation and table
numbers in docstrings are the paper's.
"""

from .version import __version__

__all__ = ["__version__"]
