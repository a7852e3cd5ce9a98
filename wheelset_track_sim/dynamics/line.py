"""The ``causal`` dynamics of a track whose supports differ along the line: bays around the wheels, stepped in time.

Modes of the whole line would have to be worked out anew for each set of supports, and there are 24 of them a bay.
Here the bays stand side by side as ``track.line`` reduces them, 47 around the wheels; when the wheels come
to the next sleeper all of them move on by one column, so a line may have any length at the same cost. Towards both
ends dampers on the rails take up what runs away. Only the rail joins bays, so a step solves one chain of nodes.

A step of ``M u'' + C u' + K u = f`` is that of N. M. Newmark with ``gamma = 1/2`` and ``beta = 1/12`` (L. Fox and E. T.
Goodwin): the period of a mode errs by ``(omega dt)^4 / 480``, which is 2e-4 at 2.5 kHz and 100 km/h. It is stable up to
``omega dt = 2.45``; where bays have higher frequencies, at low speeds, they get as much inertia ``alpha dt^2 K`` as
they need, and the rail's modes beyond ``omega dt = 2`` the inertia that holds them there. Statics do not know of it,
and what is high in frequency follows more slowly than it should; passive it stays.

The force of a step moves bays and wheels at that step itself by a compliance, to which modes left out add their static
one, as in ``causal``. Ballast under hanging sleepers is the one thing that is not linear: what it pushes with follows
from the predictor of the step. The sleepers' own weight is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse.linalg import splu

from ..runtime.arrays import Real
from ..runtime.jit import Address
from ..runtime.one_core import on_one_core
from ..track.line import TrackLine
from .banks import aligned
from .line_bay_kernels import COLUMNS, FACTORS, MIDDLE, NODES, RAIL, ROWS, STATES, R
from .line_kernels import Bays, Line, move
from .line_steps import line_parts, line_steps
from .running_wheelset import RunningWheelset

STATE = tuple(name for name in Bays._fields if name not in ("parts", "steps", "before"))
"""Arrays of the bays that change from step to step."""


@dataclass(frozen=True, eq=False)
class LineModel(RunningWheelset):
    """One wheelset on one line of bays, ready to be stepped at any speed."""

    line: TrackLine
    residual: bool
    """Whether modes of the rail that are left out displace it at the force's instant."""

    @on_one_core
    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over the line.

        Hanging sleepers count as if they lay on their ballast.
        """
        displacement: Real = (self.static_wheels() + _mean_compliance(self.line)) * wheel_load
        return displacement

    @on_one_core
    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Line:
        """Dynamics at ``speed`` m/s and in equilibrium with ``wheel_load`` N standing on both wheels at ``step``.

        Hanging sleepers begin as if they lay on their ballast.
        """
        steps = line_steps(self.line, self.residual, dx, speed)
        sleeper = (step + len(steps.own) // 2) // len(steps.own)
        state = self.standing(wheel_load, dx / speed)
        coming = np.zeros((2, 2))
        coming[0] = (self.wheelset.outputs @ state).real
        parts = line_parts(self.line, dx)
        bays = Bays(
            coming=coming,
            rail_compliance=np.zeros(1),
            motion=_standing(self.line, sleeper, step * dx, wheel_load),
            window=np.zeros(FACTORS * COLUMNS),
            chain=np.zeros((COLUMNS, 32)),
            hub=np.zeros((12, 12)),
            work=np.zeros((3, 12)),
            hung=np.zeros(COLUMNS + 1, np.int64),
            push=np.zeros((COLUMNS, STATES + 2)),
            nodes=np.zeros(2 * STATES + 3 * parts.nodes.shape[1]),
            at=np.array([sleeper, 0]),
            parts=parts,
            steps=steps,
            before=steps,
        )
        mover = _mover(bays)
        move(bays, step, 0.0, 0.0)  # nothing is loaded yet, so nothing moves
        return Line(
            **self.at(state, dx, speed, speed)._asdict(),
            coming=coming,
            rail_compliance=bays.rail_compliance,
            bays=bays,
            move=mover,
            speed=speed,
        )

    @on_one_core
    def at_speed(self, dynamics: Line, step: int, dx: float, speed: float, behind: float) -> Line:
        """Dynamics at another ``speed`` m/s, with the state of ``dynamics``, which has come to ``step``.

        For the one step at which the speed changes, ``behind`` is the speed with which that step was reached.
        """
        bays = dynamics.bays._replace(steps=line_steps(self.line, self.residual, dx, speed), before=dynamics.bays.steps)
        wheels = self.at(self.state_of(dynamics.wheels), dx, speed, behind)
        return dynamics._replace(**wheels._asdict(), bays=bays, speed=speed)

    def copied(self, dynamics: Line) -> Line:
        """Dynamics in the same state that go on by themselves."""
        own = {name: getattr(dynamics.bays, name).copy() for name in STATE}
        bays = dynamics.bays._replace(**own)
        return dynamics._replace(
            wheels=aligned(dynamics.wheels), coming=bays.coming, rail_compliance=bays.rail_compliance, bays=bays
        )

    @on_one_core
    def prepare(self, dx: float, speed: float) -> None:
        """Work out what every run at ``speed`` m/s needs, and keep it for a while."""
        line_steps(self.line, self.residual, dx, speed)


def line_model(running: RunningWheelset, line: TrackLine, lag_zero: str) -> LineModel:
    """Join a wheelset and a line."""
    return LineModel(**vars(running), line=line, residual=lag_zero != "zero")


_MOVER: list[Address] = []


def _mover(bays: Bays) -> Address:
    """``move`` for the coupled step: compiled once, whether that solves contacts or not."""
    if not _MOVER:  # to the compiler, all bays are of one type
        _MOVER.append(Address(move, 0, (bays, 0, 0.0, 0.0)))
    return _MOVER[0]


@lru_cache(maxsize=8)
def _mean_compliance(line: TrackLine) -> Real:
    """Mean over the line of what a unit load on both wheels deflects rail 1 and 2, (2,) m/N."""
    return np.asarray(line.compliance(np.arange(2 * line.bays) * (line.track.spacing / 2)).mean(axis=0))


def _standing(line: TrackLine, sleeper: int, x: float, wheel_load: float) -> Real:
    """Motion (ROWS COLUMNS,) of the bays around ``sleeper`` at rest under loads at ``x`` m, at most half a bay from it.

    Rows R hold u* of sleepers, before y.
    """
    first = sleeper - MIDDLE
    K = line.matrices(first, COLUMNS)[2]
    rows = line.rows(x, 0, first, COLUMNS) + line.rows(x, 1, first, COLUMNS)
    load = rows.toarray()[0] * wheel_load
    deflection = splu(K).solve(load).reshape(COLUMNS, -1).T
    motion = np.zeros((ROWS, COLUMNS))
    motion[:RAIL, :NODES] = deflection[:RAIL, :NODES]
    motion[4:RAIL, NODES - 1] = 0.0
    motion[R : R + len(deflection) - RAIL, :NODES] = deflection[RAIL:, :NODES]
    return motion.ravel()
