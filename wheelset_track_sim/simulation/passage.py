"""When a change of treads and rails can take effect: between two passages of what changes, or by fading.

A defect that changes waits until it is out of the contact patch, which takes a turn of the wheel at most. Roughness
and polygons never leave the patch. There the surface fades from the old shape to the new one while it rolls: at a step
``s`` the wheel and the rail have, together, the heights::

    h(s, y) = (1 - w(s)) h_old(s, y) + w(s) h_new(s, y),    w = (1 - cos(pi (s - s_0) / n)) / 2

over the ``n`` steps from ``s_0`` on. Before the fade, and after it, the surfaces are the old and the new ones exactly;
within it they are between the two, and so, but for its slow rise, are the forces. The contact problem of each step is
solved as ever: the fade is a contact law of its own, on a tread that is unrolled along the way.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d

from ..contact.law import RollingSurfaces
from ..contact.law_kernels import ContactLaw
from ..irregularities import RailHeights
from ..runtime.arrays import Real

FADE = 0.3
"""Time over which surfaces fade, s: some periods of the wheelset on the track (40 to 100 Hz), two of its bounce."""


def differences(before: ContactLaw, after: ContactLaw, first: int, count: int, tread_origin: int) -> Real:
    """Heights by which ``after`` is above ``before`` at the contact point of ``count`` steps, (2, count, ny), m.

    Lateral positions are those of the narrower law, which hold the contacts on its surfaces.
    """
    ny = min(before.y.shape[1], after.y.shape[1])
    steps = np.arange(first, first + count)
    rise = np.zeros((2, count, ny))
    for law, sign in ((after, 1.0), (before, -1.0)):
        shown = slice((law.y.shape[1] - ny) // 2, (law.y.shape[1] + ny) // 2)
        for wheel in range(2):
            row = law.rail_row[wheel, steps % law.rail_row.shape[1]]
            rise[wheel] += sign * law.tread[wheel, (steps - tread_origin) % law.tread.shape[1], shown]
            rise[wheel] += sign * law.rail[row, shown]
    return rise


def passage(before: ContactLaw, after: ContactLaw, earliest: int, tread_origin: int) -> int | None:
    """First step from ``earliest`` on, within a turn of the wheel, with nothing in a patch by which two laws differ.

    None if there is no such step: then the surfaces have to fade.
    """
    if after is before:
        return earliest
    reach = max(len(before.x), len(after.x)) // 2
    for steps in (1, after.tread.shape[1]):  # mostly nothing is there
        rise = differences(before, after, earliest - reach, steps + 2 * reach, tread_origin)
        blocked = maximum_filter1d((np.abs(rise) > 1e-15).any(axis=(0, 2)), 2 * reach + 1)[reach : reach + steps]
        clear = np.flatnonzero(~blocked)
        if len(clear):
            return earliest + int(clear[0])
    return None


def faded(
    before: RollingSurfaces, after: RollingSurfaces, first: int, steps: int, tread_origin: int
) -> RollingSurfaces:
    """Surfaces that go over from ``before`` to ``after`` within ``steps`` from step ``first`` on.

    Parameters
    ----------
    before, after
        Surfaces on the same elements.
    first, steps
        Where the fade begins, and its length.
    tread_origin
        Step at which angle 0 of the treads meets the rail.

    Returns
    -------
    RollingSurfaces
        Treads unrolled, (steps + 2 margins, m), with the heights of the rails in them; their row 0 is at the step
        ``first - len(x)``. The rails are smooth.
    """
    x, y = max(before.x, after.x, key=len), max(before.y, after.y, key=len)
    at = np.arange(first - len(x), first + steps + len(x))
    weight = 0.5 - 0.5 * np.cos(np.pi * np.clip((at - first) / steps, 0.0, 1.0))[:, np.newaxis]
    treads = []
    for wheel in range(2):
        old, new = (
            surfaces.treads[wheel][(at - tread_origin) % len(surfaces.treads[wheel])]
            + surfaces.rails[wheel].at(at % len(surfaces.rails[wheel].row))
            for surfaces in (before, after)
        )
        treads.append((1.0 - weight) * old + weight * new)
    smooth = RailHeights(np.zeros(1, np.int32), np.zeros((1, treads[0].shape[1])))
    return RollingSurfaces(x, y, (treads[0], treads[1]), (smooth, smooth), after.sharper)
