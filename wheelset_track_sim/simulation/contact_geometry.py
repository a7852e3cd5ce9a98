"""The surfaces that a scenario lets roll on each other."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from ..contact.geometry import OUTWARDS, ContactGeometry, ProfilePair
from ..contact.profile_points import COMPUTED, ProfilePoints, load_points
from ..contact.profiles import LateralProfile, Points, RailHead, Straight, gauge_face, inclined
from ..errors import InputError
from ..scenario.scenario import WHEELS, Scenario
from ..wheelset.kinds import AnyWheelset

FORMS: dict[str, LateralProfile] = {
    "cylinder": Straight(),
    "cone_1_40": Straight(1 / 40),
    "cone_1_20": Straight(1 / 20),
    "head_60e1": RailHead(),
}


def contact_geometry(scenario: Scenario, wheelset: AnyWheelset) -> ContactGeometry:
    """Contact geometry of a scenario, of which ``wheelset`` is the wheelset.

    Raises InputError for profiles that cannot be read or used, and where they touch too steeply.
    """
    given, pairs = scenario.profiles, []
    places = zip(WHEELS, OUTWARDS, wheelset.rolling_circles, strict=True)
    for number, (name, outwards, circle) in enumerate(places, start=1):
        wheel = _profile(f"profiles.{name}", "wheel", getattr(given, name))
        rail = _profile(f"profiles.rail_{number}", "rail", getattr(given, f"rail_{number}"))
        rail = inclined(rail, given.inclination)
        shift = outwards * scenario.lateral_offset
        if given.gauge is not None:
            try:
                shift += outwards * circle - (given.gauge / 2 - gauge_face(rail))
            except InputError as refusal:
                raise InputError(f"profiles.rail_{number}: {refusal}") from None
        try:
            pairs.append(ProfilePair(wheel, rail, shift))
        except InputError:
            raise InputError(
                f"{name} is {abs(shift):.3g} m {'outside' if shift > 0 else 'inside'} the middle of its rail, beside "
                f"the head: give a smaller lateral_offset, or a profiles.gauge that the wheelset fits"
            ) from None
    return ContactGeometry(wheel_radius=wheelset.rolling_radius, pairs=(pairs[0], pairs[1]))


def _profile(where: str, side: str, source: Any) -> LateralProfile:
    try:
        if isinstance(source, str) and source in COMPUTED[side]:
            return FORMS[source]
        return _measured(side, load_points(side, source))
    except InputError as refusal:
        raise InputError(f"{where}: {refusal}") from None


@lru_cache(maxsize=16)
def _measured(side: str, points: ProfilePoints) -> Points:
    profile = Points(np.array(points.y), np.array(points.z))
    if side == "rail":
        middle, *ends = profile.height([0.0, *profile.span])
        if max(ends) > middle:
            raise InputError("z rises from the middle of the head to an end of the points: give z positive upwards")
    return profile
