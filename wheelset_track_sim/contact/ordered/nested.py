"""Elements in the order in which a smooth contact takes them in, and the factor of their influence matrix."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ..geometry import ContactGeometry
from ..hertz import HertzContact
from ..influence import influence_table
from .hinge_kernels import BLOCK, Hinges
from .order_kernels import NestedContacts
from .panel_kernels import PANEL, factored, inverted, row

MOST_ELEMENTS = 1536
"""Contacts have about half of them, at 500 kN; 12 MB are stored for them, and a quarter of a second is spent."""
DISTANCE = 3e-3
"""b of ``hinge_kernels``, m."""


def nested_contacts(
    geometry: ContactGeometry,
    wheel: int,
    x: Real,
    y: Real,
    separation: Real,
) -> NestedContacts:
    """Elements of the area ``x`` by ``y``, m, under ``wheel`` (0 or 1), up to MOST_ELEMENTS.

    ``separation`` (nx, ny), m, is that of the nominal surfaces. Elements at the border of the area are left out: a
    contact that comes near them is not for this method.
    """
    i, j = _order(geometry, wheel, separation)
    element = i * len(y) + j
    ordered = separation.ravel()[element]
    left_out = np.delete(separation.ravel(), element).min(initial=np.inf)
    material = geometry.youngs_modulus, geometry.poissons_ratio
    spacing = float(x[len(x) // 2 + 1]), float(y[len(y) // 2 + 1])  # from 0: the same to the last bit in every area
    factor, inverse, punch, own, far = _factor(*material, *spacing, tuple(i - len(x) // 2), tuple(j - len(y) // 2))
    return NestedContacts(
        element=element,
        x=x[i],
        y=y[j],
        separation=ordered,
        beyond=np.minimum.accumulate(np.append(ordered, left_out)[::-1])[::-1].copy(),
        reach=np.maximum.accumulate(np.append(0, np.abs(i - len(x) // 2))),
        factor=factor,
        inverse=inverse,
        punch=punch,
        own=own,
        far=far,
    )


def no_nested_contacts() -> NestedContacts:
    """No elements: every contact is solved by the plain active set."""
    none = np.zeros(0)
    return NestedContacts(
        np.zeros(0, np.int64), none, none, none, np.full(1, -np.inf), np.zeros(1, np.int64), none, none, none, 0.0, 0.0
    )


def hinges_of(nested: Sequence[NestedContacts], fall: Real, ny: int, modulus: float, dx: float, dy: float) -> Hinges:
    """Hinges of the contact filter, for the elements whose part of the inverse is there, of one wheel or of both.

    ``fall`` (wheels, 2 nx + 1), m, is that of ``Hinges``, ``ny`` the width of the area in elements, ``modulus`` E*, Pa,
    and ``dx``, ``dy`` the size of the elements, m.
    """
    m = min(len(each.punch) for each in nested)
    parts = [_hinges(each, m, ny, dx * dy) for each in nested]
    weights, opening, blocks, element, extent = (np.stack(each) for each in zip(*parts, strict=True))
    along, across = round(DISTANCE / dx), round(DISTANCE / dy)
    return Hinges(weights, opening, blocks, element, extent, fall, 0.45 * modulus / DISTANCE, along, across)


def _hinges(nested: NestedContacts, m: int, ny: int, element_area: float) -> tuple[NDArray[Any], ...]:
    """The arrays of ``Hinges`` for one wheel."""
    inverse, punch, element = np.zeros((m, m)), nested.punch[:m], nested.element[:m]
    for c in range(m):
        inverse[c, : c + 1] = nested.inverse[row(c) : row(c) + c + 1]
    sigma, delta, rho = element_area * punch**2, inverse @ nested.separation[:m] / punch, inverse / punch[:, np.newaxis]
    before = np.arange(BLOCK, m, BLOCK)
    stiffness, moment = (np.cumsum(each)[before - 1] for each in (sigma, sigma * delta))
    means = np.cumsum(sigma[:, np.newaxis] * rho, axis=0)[before - 1] / stiffness[:, np.newaxis]
    edge = np.maximum.accumulate(delta)[before]
    blocks = np.stack([moment / stiffness, stiffness, edge, stiffness * edge - moment])
    first = np.array([[0.0], [0.0], [delta[0]], [0.0]])
    aside = np.maximum.accumulate(np.append(0, np.abs(element % ny - ny // 2)))
    return (
        np.vstack([rho, np.zeros((1, m)), means]).astype(np.float32),
        np.stack([delta, sigma]),
        np.hstack([first, blocks]),
        element.astype(np.uint32),
        np.stack([nested.reach[: m + 1], aside]),
    )


def no_hinges() -> Hinges:
    """No filter."""
    none = np.zeros((1, 4, 0))
    return Hinges(
        none.astype(np.float32),
        none,
        none,
        np.zeros((1, 0), np.uint32),
        np.zeros((1, 2, 1), np.int64),
        none[0],
        0.0,
        1,
        1,
    )


def _order(geometry: ContactGeometry, wheel: int, separation: Real) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices i and j of the elements, in whole panels, sorted by the size of the contact that they are at the edge of.

    The ellipse of contact is a little slimmer than the ellipses of equal separation (Hertz), which the separation along
    x is scaled to account for.
    """
    hertz = HertzContact(geometry.wheel_radius, geometry.pairs[wheel].crown, geometry.contact_modulus)
    slimmer = hertz.axis_ratio**2 * hertz.radius_x / hertz.radius_y
    nx, ny = separation.shape
    at_edge = slimmer * separation[:, ny // 2, None] + separation[nx // 2]
    inner = np.zeros(separation.shape, np.bool_)
    inner[1:-1, 1:-1] = np.isfinite(separation[1:-1, 1:-1])
    count = min(int(inner.sum()), MOST_ELEMENTS) // PANEL * PANEL
    order = np.argsort(np.where(inner, at_edge, np.inf), axis=None, kind="stable")[:count]
    return order // ny, order % ny


@lru_cache(maxsize=4)
def _factor(
    youngs_modulus: float, poissons_ratio: float, dx: float, dy: float, i: tuple[int, ...], j: tuple[int, ...]
) -> tuple[Real, Real, Real, float, float]:
    di, dj = (np.abs(np.subtract.outer(index, index)) for index in (np.array(i), np.array(j)))
    table = influence_table(di.max() + 1, dj.max() + 1, dx, dy, youngs_modulus, poissons_ratio)
    factor = factored(table[di, dj])
    largest = len(i) // 2 // PANEL * PANEL
    inverse = inverted(factor, largest)
    punch = np.array([inverse[row(c) : row(c) + c + 1].sum() for c in range(largest)])
    distance = np.hypot(np.arange(len(table))[:, None] * dx, np.arange(table.shape[1]) * dy)
    far = float((table * distance).ravel()[1:].min())
    return factor, inverse, punch, float(table[0, 0]), far
