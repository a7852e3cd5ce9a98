"""Which way the axes of a lateral profile point, recognised from its shape.

Files of wheels and rails count heights upwards or downwards, and lateral positions to the field side, to the track's
side, or to the left. A wheel shows it by its flange, which is on the gauge side and has the larger radius; a rail
shows by its crown where up is.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..errors import InputError, warn
from ..runtime.arrays import Real

Turn = Literal["auto", "none", "y", "z", "both"]

FLANGE = 8e-3
"""What is farther above or below the tread is the flange, m, unless it is a narrow edge."""
HIGHEST = 0.06
"""Height of a flange at most, m."""
TIP = (-0.075, -0.035)
"""Where the flange is highest: usual wheels have the rolling circle 70 mm from the back of a flange 30 mm thick, m."""
RISE = 2e-3
"""What both ends of a rail's head are above its middle at least if z counts downwards, m."""
OFF_MIDDLE = 0.012
"""How far the middle between the sides of a head may be from y = 0, m: a gauge face wears by less than twice that."""
MIRRORED = 2e-3
"""What the field corner is lower than the gauge corner at least where a rail looks mirrored, m."""
CORNER = 0.028
"""Where the corners of a rail are compared, m from the middle."""
FIELD_RISE = 5e-3
"""What a tread is higher at the field side than on the rolling circle at most, m: more than false flanges are."""
FLATTEST = 1e-4
"""What z changes by at least, m, unless it is constant."""
CLEAR = 2.0
"""How many times as wide as what is on its other side a flange is at least."""


def oriented(side: str, y: Real, z: Real, name: str, turn: Turn = "auto") -> tuple[Real, Real]:
    """Points with y rising to the field side and z positive where there is more material.

    Parameters
    ----------
    side
        ``wheel`` or ``rail``.
    y, z
        Points one beside the other, in either order, m.
    name
        File, or what else the points are from, for messages.
    turn
        Axes to turn; ``auto`` recognises them, and warns of what it turns.

    Raises
    ------
    InputError
        If the shape does not show them, or is that of no wheel or rail around y = 0.
    """
    if turn == "auto":
        turned = _of_wheel(y, z) if side == "wheel" else _of_rail(y, z, name)
        for axis, words in turned.items():
            warn(f"{name}: {words}: it is read with {axis} turned, give turn: {axis} to confirm that, or turn: none")
    else:
        turned = {axis: "" for axis in ("y", "z") if turn in (axis, "both")}
    y, z = (0.0 - y if "y" in turned else y), (0.0 - z if "z" in turned else z)
    if y[0] > y[-1]:
        y, z = y[::-1], z[::-1]
    if side == "rail":
        _check_rail(y, z)
    else:
        _check_wheel(y, z, sure=turn != "auto")
    return y, z


def _even(y: Real, z: Real) -> tuple[Real, Real]:
    """The same at even distances."""
    order = np.argsort(y, kind="stable")
    grid = np.linspace(y.min(), y.max(), 501)
    return grid, np.interp(grid, y[order], z[order])


def _of_wheel(y: Real, z: Real) -> dict[str, str]:
    """Axes of a wheel to turn, with what shows it; none without a flange."""
    y, z = _even(y, z)
    away = z - np.median(z)  # most of a wheel is tread
    above, below = away > FLANGE, away < -FLANGE
    if not (above.any() or below.any()):
        return {}
    if max(above.sum(), below.sum()) < CLEAR * min(above.sum(), below.sum()):
        raise InputError(
            "z has a hump and a groove of similar size beside the tread, so either may be the flange: give turn: none, "
            "y, z or both"
        )
    flange = above if above.sum() > below.sum() else below
    place = int(np.abs(np.where(flange, away, 0.0)).argmax())
    found = {}
    if flange is below:
        found["z"] = f"the flange has z = {1e3 * away[place]:+.3g} mm over the tread, as if its radius were less there"
    if place > len(y) / 2:
        found["y"] = f"the flange is at y = {1e3 * y[place]:+.3g} mm, as if it were on the field side"
    return found


def _check_wheel(y: Real, z: Real, *, sure: bool) -> None:
    y, z = _even(y, z)
    away = z - np.median(z)
    if away.max() > HIGHEST or 0.0 < np.ptp(z) < FLATTEST:
        raise InputError(
            f"z of a wheel goes from {z.min():.3g} to {z.max():.3g} m, and flanges are up to {HIGHEST:g} m high: give "
            "the unit of z"
        )
    tip = float(y[away.argmax()])
    if away.max() > FLANGE and not TIP[0] < tip < TIP[1]:
        raise InputError(
            f"the flange is highest at y = {tip:.4g} m, and y counts from the rolling circle, usually 0.07 m from the "
            "back of the flange: give y from there, or origin: the y of the rolling circle in the file"
        )
    outside = float(z[-1] - np.interp(0.0, y, z))
    if outside > FIELD_RISE and not sure:
        raise InputError(
            f"z at the field side is {1e3 * outside:.3g} mm above z at y = 0, but a tread falls by some mm there: give "
            "turn: y, z or both, or turn: none to use it as it is"
        )


def _of_rail(y: Real, z: Real, name: str) -> dict[str, str]:
    """Axes of a rail to turn, with what shows it; of y it only warns, because rails are laid turned, too."""
    y, z = _even(y, z)
    rise = min(z[0], z[-1]) - float(np.median(z[len(y) // 4 : -len(y) // 4]))
    turned = {}
    if rise > RISE:
        turned["z"] = f"z rises by {1e3 * rise:.3g} mm from the middle of the head to both sides, as if it were hollow"
        z = -z
    gauge, field = np.interp([-CORNER, CORNER], y, z, left=np.nan, right=np.nan)
    if gauge - field > MIRRORED:
        warn(
            f"{name}: the corner at y = {1e3 * CORNER:+g} mm is {1e3 * (gauge - field):.3g} mm lower than at "
            "the gauge face, as if worn more: give turn: y if y counts to the gauge side, or turn: none"
        )
    return turned


def _check_rail(y: Real, z: Real) -> None:
    even, height = _even(y, z)
    if max(height[0], height[-1]) > np.interp(0.0, even, height):
        raise InputError("z rises from the middle of the head to an end of the points: give z positive upwards")
    if 0.0 < np.ptp(z) < FLATTEST:
        raise InputError(f"z of a rail goes from {z.min():.3g} to {z.max():.3g} m only: give the unit of z")
    top = int(height.argmax())
    for depth in (0.014, 0.010, 0.006):
        low = height < height[top] - depth
        if low[:top].any() and low[top:].any():
            middle = 0.5 * float(even[:top][low[:top]][-1] + even[top:][low[top:]][0])
            if abs(middle) > OFF_MIDDLE:
                raise InputError(
                    f"the middle of the head is at y = {middle:.4g} m: give y from there, or origin: {middle:.4g}"
                )
            return
