"""One normal contact problem put to this package, to tamaas and to ContactMechanics: same elements, same half-spaces.

What does not depend on the gap is ready beforehand for all three: influence coefficients or their Fourier transform.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.contact import ContactGeometry, ProfilePair, build_contact_law, solve_patch
from wheelset_track_sim.contact.active_set_kernels import CONVERGED, solve_active_set
from wheelset_track_sim.contact.law_kernels import ContactLaw, total_separation
from wheelset_track_sim.contact.profiles import RailHead
from wheelset_track_sim.irregularities import Breakout

Real = NDArray[np.float64]
TOLERANCE = 1e-9
"""Asked of the iterative solvers; their pressures then agree with the active set, which is exact, within 1e-6."""


class Problem(NamedTuple):
    """Elements dx x dy under an undeformed separation; ``force`` is what ``approach`` gives."""

    law: ContactLaw
    gap: Real  # (nx, ny) m
    dx: float
    dy: float
    modulus: float  # E*, Pa
    approach: float  # m
    force: float  # N
    pressure: Real  # (nx, ny) Pa


def wheel_on_rail(dx: float, dy: float, depth: float, defect: Breakout | None, tread: int) -> Problem:
    """A wheel with or without damage on a 60E1 head."""
    geometry = ContactGeometry()
    return _problem(geometry, dx, dy, depth, [defect] if defect else [], tread)


def sphere(dx: float, depth: float) -> Problem:
    """Hertz: a wheel whose tread meets a crown of about its own radius."""
    geometry = ContactGeometry(pairs=(ProfilePair(rail=RailHead((ContactGeometry().wheel_radius,), (0.036,))),) * 2)
    return _problem(geometry, dx, dx, depth, [], 0)


def _problem(geometry: ContactGeometry, dx: float, dy: float, depth: float, defects: list, tread: int) -> Problem:
    law = build_contact_law(defects, geometry, dx, round(2.713 / dx), dy=dy, tables=False)
    gap = total_separation(law, 0, tread, 0)
    patch = solve_patch(law, 0, tread, 0, gap.min() + depth)
    return Problem(law, gap, dx, dy, geometry.contact_modulus, patch.approach, patch.force, patch.pressure)


def ours(problem: Problem) -> Callable[[], Real]:
    """Active set from a guess by the undeformed gap, as if nothing were known of a step before."""
    law, pressure = problem.law, np.empty_like(problem.gap)
    mirrored = bool((problem.gap == problem.gap[:, ::-1]).all())

    def solve() -> Real:
        guess = np.zeros(problem.gap.shape, np.bool_)
        *_, status = solve_active_set(
            problem.gap, mirrored, law.influence, law.element_area, problem.approach, 0.0, guess, pressure
        )
        assert status == CONVERGED
        return pressure

    return solve


def tamaas(problem: Problem) -> Callable[[], Real]:
    """Conjugate gradients of Polonsky and Keer at the force; not periodic."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    nx, ny = problem.gap.shape
    size = [nx * problem.dx, ny * problem.dy]
    heights = -np.minimum(problem.gap, 0.1)

    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, size, [nx, ny])
    model.E, model.nu = problem.modulus, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tm.PolonskyKeerRey(model, heights, TOLERANCE)
    solver.setIntegralOperator("dcfft")
    solver.max_iter = 5000

    def solve() -> Real:
        model.traction[:] = 0.0
        model.displacement[:] = 0.0
        solver.solve(problem.force / (size[0] * size[1]))
        return np.asarray(model.traction).reshape(nx, ny)

    return solve


def contact_mechanics(problem: Problem) -> Callable[[], Real]:
    """The same method in Python; lengths in dx, stresses in E*."""
    import ContactMechanics
    from SurfaceTopography import Topography

    nx, ny = problem.gap.shape
    size = (float(nx), ny * problem.dy / problem.dx)
    scale = problem.modulus * problem.dx**2
    surface = Topography(-np.minimum(problem.gap, 0.1) / problem.dx, size)

    system: Any = ContactMechanics.make_system(
        substrate=ContactMechanics.FreeFFTElasticHalfSpace((nx, ny), 1.0, size), surface=surface
    )

    def solve() -> Real:
        found = system.minimize_proxy(
            external_force=problem.force / scale, pentol=TOLERANCE, forcetol=TOLERANCE, maxiter=5000
        )
        assert found.success
        return np.asarray(found.jac)[:nx, :ny] * problem.modulus * problem.dx / problem.dy

    return solve


SOLVERS = {"this package": ours, "tamaas": tamaas, "ContactMechanics": contact_mechanics}
