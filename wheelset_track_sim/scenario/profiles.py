"""The lateral profiles of a scenario, and the contact geometry that follows from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

from ..contact.geometry import OUTWARDS, ContactGeometry, ProfilePair
from ..contact.named_profiles import COMPUTED, plain_profile, read_profile
from ..contact.profiles import LateralProfile, gauge_face, inclined
from ..errors import InputError
from ..inputs.schema import check, parsed, quantity


def _profile(side: str, default: str) -> Any:
    return parsed(partial(read_profile, side), partial(plain_profile, side), default=COMPUTED[side][default])


@dataclass(frozen=True)
class Profiles:
    """Lateral profiles of wheels and rails; in files, names, files or points (``docs/reference/profiles.md``)."""

    wheel_1: LateralProfile = _profile("wheel", "cylinder")
    wheel_2: LateralProfile = _profile("wheel", "cylinder")
    rail_1: LateralProfile = _profile("rail", "head_60e1")
    rail_2: LateralProfile = _profile("rail", "head_60e1")
    inclination: float = quantity(
        "", 0.0, 0.1, "the inclination of the rails to the middle of the track, such as 1/40 = 0.025", default=0.0
    )
    gauge: float | None = quantity("m", 0.9, 1.8, "the gauge", default=None)
    """Distance of the rails, m, 14 mm below their tops; if None, each rolling circle is over the middle of its rail."""

    def __post_init__(self) -> None:
        check(self, "profiles")

    @lru_cache(maxsize=16)  # noqa: B019  profiles are few, and a live change of a scenario asks again
    def geometry(
        self, rolling_radius: float, rolling_circles: tuple[float, float], lateral_offset: float
    ) -> ContactGeometry:
        """Contact geometry of a wheelset between these profiles.

        Parameters
        ----------
        rolling_radius
            Radius of both wheels, m.
        rolling_circles
            y of the rolling circles of wheels 1 and 2 on the wheelset, m.
        lateral_offset
            Distance of the wheelset from the middle of the track, to the left, m.

        Raises
        ------
        InputError
            If a wheel is beside its rail, or touches it too steeply.
        """
        pairs = []
        sides = ((self.wheel_1, self.rail_1), (self.wheel_2, self.rail_2))
        places = zip(sides, OUTWARDS, rolling_circles, strict=True)
        for number, ((wheel, upright), outwards, circle) in enumerate(places, start=1):
            rail = inclined(upright, self.inclination)
            shift = outwards * lateral_offset
            if self.gauge is not None:
                try:
                    shift += outwards * circle - (self.gauge / 2 - gauge_face(rail))
                except InputError as refusal:
                    raise InputError(f"profiles.rail_{number}: {refusal}") from None
            try:
                pairs.append(ProfilePair(wheel, rail, shift))
            except InputError:
                raise InputError(
                    f"wheel_{number} is {abs(shift):.3g} m {'outside' if shift > 0 else 'inside'} the middle of its "
                    f"rail, beside the head: give a smaller lateral_offset, or a profiles.gauge that the wheelset fits"
                ) from None
        return ContactGeometry(wheel_radius=rolling_radius, pairs=(pairs[0], pairs[1]))
