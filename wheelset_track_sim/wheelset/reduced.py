"""Wheelset reduced to complex poles: contact displacements and axle stresses from two contact forces.

With the real contact forces F (2,) in N, positive in compression, and one complex state q a pole::

    q' = poles * q + inputs @ F
    xi_w = Re(outputs @ q)                               (2,) m, away from the rail
    sigma = Re(stress_outputs @ q) + stress_feedthrough @ F      (nodes, 6) Pa
    sensed = Re(sensor_outputs @ q) + sensor_feedthrough @ F     (rows,) in SI units, see ``sensor_rows``

Of a conjugate pair the pole with positive imaginary part is kept; its factor 2 is in the outputs. The type knows
nothing of how the poles were found: modes computed or measured elsewhere can be imported through ``from_arrays``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..runtime.arrays import Complex, Real

COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Order of stress components: x along the track, y to the left along the axle, z up."""


@dataclass(frozen=True, eq=False)
class ReducedWheelset:
    """Poles, shapes at the contacts and stress shapes of P modes at N stress nodes. SI units; wheels in order 1, 2."""

    poles: Complex
    """(P,) rad/s, imaginary part >= 0."""
    inputs: Complex
    """(P, 2) of a unit force on wheel 1, 2."""
    outputs: Complex
    """(2, P) to ``xi_w`` of wheel 1, 2."""
    stress_outputs: Complex
    """(N, 6, P) to stress components."""
    stress_feedthrough: Real
    """(N, 6, 2) Pa/N: static stress less that of the kept modes."""
    displacement_residual: Real
    """(2, 2) m/N: static compliance less that of the kept modes. For information only: nothing uses it, because the
    compliance near the contact belongs to the contact model (and in a finite-element model depends on the mesh)."""
    node_names: tuple[str, ...]
    node_positions: Real
    """(N, 3): x, y, z from the middle of the axle, m."""
    mass: float
    """kg, axle boxes included."""
    rolling_radius: float
    """m."""
    sensor_outputs: Complex = field(default_factory=lambda: np.zeros((0, 0), np.complex128))
    """(S, P) to the rows of sensors."""
    sensor_feedthrough: Real = field(default_factory=lambda: np.zeros((0, 2)))
    """(S, 2) of the forces at the same instant."""

    def __post_init__(self) -> None:
        modes, nodes, rows = len(self.poles), len(self.node_names), len(self.sensor_outputs)
        if not rows:
            object.__setattr__(self, "sensor_outputs", np.zeros((0, modes), np.complex128))
        shapes = {
            "poles": (modes,),
            "inputs": (modes, 2),
            "outputs": (2, modes),
            "stress_outputs": (nodes, 6, modes),
            "stress_feedthrough": (nodes, 6, 2),
            "displacement_residual": (2, 2),
            "node_positions": (nodes, 3),
            "sensor_outputs": (rows, modes),
            "sensor_feedthrough": (rows, 2),
        }
        for name, shape in shapes.items():
            array = getattr(self, name)
            if array.shape != shape:
                raise InputError(f"reduced wheelset: {name} has shape {array.shape}: give {shape}")
            if not np.isfinite(array).all():
                raise InputError(f"reduced wheelset: {name} has values that are not finite: correct them")
        if (self.poles.real >= 0).any() or (self.poles.imag < 0).any():
            raise InputError("reduced wheelset: poles must have negative real parts and imaginary parts of at least 0")

    @property
    def frequencies(self) -> Real:
        """Undamped natural frequencies (P,), Hz."""
        frequencies: Real = np.abs(self.poles) / (2 * np.pi)
        return frequencies

    def node(self, name: str) -> int:
        """Index of a stress node; raises InputError for a name it does not have."""
        if name not in self.node_names:
            raise InputError(f"stress node {name} is not known: known are {', '.join(self.node_names) or 'none'}")
        return self.node_names.index(name)

    def receptance(self, frequencies: Real) -> Complex:
        """Receptances (F, 2, 2) in m/N at frequencies (F,) in Hz: ``xi_w`` of a wheel for a force on a wheel."""
        return self._response(self.outputs, frequencies)

    def stress_receptance(self, frequencies: Real) -> Complex:
        """Stress over force (F, N, 6, 2) in Pa/N at frequencies (F,) in Hz, static residual included."""
        return self._response(self.stress_outputs, frequencies) + self.stress_feedthrough

    def static_receptance(self) -> Real:
        """Static receptances (2, 2) of the modes, m/N."""
        return np.real(self.receptance(np.zeros(1))[0])

    def static_stress(self) -> Real:
        """Static stress over force (N, 6, 2), Pa/N."""
        return np.real(self.stress_receptance(np.zeros(1))[0])

    def _response(self, outputs: Complex, frequencies: Real) -> Complex:
        """Frequency response (F, ..., 2) of outputs (..., P); half of each pole and half of its conjugate."""
        s = 2j * np.pi * np.asarray(frequencies)[:, None]
        modes = len(self.poles)
        by_wheel = (outputs[..., :, None] * self.inputs / 2).reshape(-1, modes, 2)
        residues = np.moveaxis(by_wheel, 1, 0).reshape(modes, -1)
        response = (1 / (s - self.poles)) @ residues + (1 / (s - self.poles.conj())) @ residues.conj()
        shaped: Complex = response.reshape(len(s), *outputs.shape[:-1], 2)
        return shaped

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by field name."""
        return {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> ReducedWheelset:
        """Reduced wheelset from arrays by field name; raises KeyError, ValueError or InputError."""

        def read(name: str, kind: type[Any]) -> NDArray[Any]:
            return np.asarray(arrays[name], dtype=kind)

        return cls(
            poles=read("poles", np.complex128),
            inputs=read("inputs", np.complex128),
            outputs=read("outputs", np.complex128),
            stress_outputs=read("stress_outputs", np.complex128),
            stress_feedthrough=read("stress_feedthrough", np.float64),
            displacement_residual=read("displacement_residual", np.float64),
            node_names=tuple(str(name) for name in arrays["node_names"]),
            node_positions=read("node_positions", np.float64),
            mass=float(read("mass", np.float64)),
            rolling_radius=float(read("rolling_radius", np.float64)),
            sensor_outputs=read("sensor_outputs", np.complex128),
            sensor_feedthrough=read("sensor_feedthrough", np.float64),
        )
