"""Axle stresses from given contact forces alone (Section 2.4): no track, no contact.

The wheelset answers with its poles, and at once with what they leave of the static stress. The step is that of the
simulation (``hold``), exact for forces that are linear between samples. A straight line between samples of
a wave of frequency f is lower than the wave by ``sinc(f dt)^2``, 12 % at a fifth of the sampling rate: so a record with
fewer than ``RATE`` samples a second is first sampled more finely, in its own band (``samples.resampling``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from ..errors import InputError
from ..runtime.arrays import Real
from ..samples.resampling import band_limited
from ..wheelset.reduced import COMPONENTS, ReducedWheelset
from .hold import hold
from .running_wheelset import stress_rows

RATE = 25e3
"""Samples a second with which the wheelset is stepped at least: a wave of 2500 Hz is lower by 3 % then."""


def stresses_from_forces(
    wheelset: ReducedWheelset, forces: Real, dt: float, nodes: Sequence[str] | None = None
) -> Real:
    """Stress (n, nodes, 6) in Pa under forces (n, 2) in N on wheel 1 and 2, positive in compression, every ``dt`` s.

    Before the first sample the wheelset stands in equilibrium with the first forces, so what the axle rang with then is
    missing until it has died away. ``nodes`` are all if None. Raises InputError for a node that the wheelset does not
    have, and for forces that are not finite.
    """
    if not np.isfinite(forces).all():
        raise InputError("forces are not finite: give numbers for every sample")
    finer = max(1, math.ceil(dt * RATE - 1e-9))
    if finer > 1:
        forces = band_limited(forces, np.arange((len(forces) - 1) * finer + 1) / finer)
    names = wheelset.node_names if nodes is None else tuple(nodes)
    rows, kept = stress_rows(wheelset, names)
    outputs = wheelset.stress_outputs[rows].reshape(-1, len(wheelset.poles))[kept]
    stress = forces[::finer] @ wheelset.stress_feedthrough[rows].reshape(-1, 2)[kept].T
    step = hold(wheelset.poles, dt / finer)
    for pole, inputs, output, a, b0, b1 in zip(wheelset.poles, wheelset.inputs, outputs.T, *step, strict=True):
        load = forces @ inputs
        standing = -load[0] / pole
        state = scipy.signal.lfilter([b1, b0], [1.0, -a], load, zi=np.array([standing - b1 * load[0]]))[0][::finer]
        stress += np.multiply.outer(state.real, output.real) - np.multiply.outer(state.imag, output.imag)
    found = np.zeros((len(stress), len(names) * len(COMPONENTS)))
    found[:, kept] = stress
    return found.reshape(len(stress), len(names), len(COMPONENTS))
