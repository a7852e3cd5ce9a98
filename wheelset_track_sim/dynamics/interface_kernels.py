"""The one interface of the coupled step to the dynamics, and its implementations: ``causal``, ``line`` and ``paper``.

At a step the wheels and rails are displaced by a part that past forces have caused, and by a part in proportion to the
force F of the step itself::

    xi = displacements(step) + compliance F

    compliance  m/N  ``wheel_compliance`` (2,), ``rail_compliance`` (L,) by place in the bay; (1,) if it has no places

``contact.law_kernels`` solves the contact with the sum of both compliances as c0, so contact and structure need no
iteration. A step calls ``displacements``, solves the contacts, and calls ``stresses`` and ``sensed``, then
``advance``, with the forces. The compiler picks the implementation by the type of ``dynamics``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.extending import overload

from . import causal_kernels, line_kernels, paper_kernels

_IMPLEMENTATIONS = {
    causal_kernels.Causal: causal_kernels,
    line_kernels.Line: line_kernels,
    paper_kernels.Paper: paper_kernels,
}


def displacements(dynamics: Any, step: int, xi: np.ndarray) -> None:
    """Fill ``xi`` (2, 2), m: [0] wheels and [1] rails by wheel, at ``step``, without the force of that step itself."""
    _IMPLEMENTATIONS[type(dynamics)].displacements(dynamics, step, xi)


def advance(dynamics: Any, step: int, forces: np.ndarray) -> None:
    """Apply the ``forces``, (2,), N, of ``step`` and move on to the next one."""
    _IMPLEMENTATIONS[type(dynamics)].advance(dynamics, step, forces)


def stresses(dynamics: Any, forces: np.ndarray, stress: np.ndarray) -> None:
    """Fill ``stress`` (S,) Pa at the step whose ``forces`` (2,) N are given; before ``advance``."""
    _IMPLEMENTATIONS[type(dynamics)].stresses(dynamics, forces, stress)


def sensed(dynamics: Any, forces: np.ndarray, signals: np.ndarray) -> None:
    """Fill ``signals`` (rows,) of sensors at the step whose ``forces`` (2,) N are given; before ``advance``."""
    _IMPLEMENTATIONS[type(dynamics)].sensed(dynamics, forces, signals)


def _kernel_of(dynamics: Any, name: str) -> Callable[..., Any] | None:
    module = _IMPLEMENTATIONS.get(getattr(dynamics, "instance_class", type(None)))
    return getattr(module, name) if module else None


@overload(displacements, strict=False)
def _displacements(dynamics: Any, step: Any, xi: Any) -> Any:
    implementation = _kernel_of(dynamics, "displacements")
    return implementation and (lambda dynamics, step, xi: implementation(dynamics, step, xi))


@overload(advance, strict=False)
def _advance(dynamics: Any, step: Any, forces: Any) -> Any:
    implementation = _kernel_of(dynamics, "advance")
    return implementation and (lambda dynamics, step, forces: implementation(dynamics, step, forces))


@overload(stresses, strict=False)
def _stresses(dynamics: Any, forces: Any, stress: Any) -> Any:
    implementation = _kernel_of(dynamics, "stresses")
    return implementation and (lambda dynamics, forces, stress: implementation(dynamics, forces, stress))


@overload(sensed, strict=False)
def _sensed(dynamics: Any, forces: Any, signals: Any) -> Any:
    implementation = _kernel_of(dynamics, "sensed")
    return implementation and (lambda dynamics, forces, signals: implementation(dynamics, forces, signals))
