"""How a study draws from the distributions along its axes."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal

import numpy as np

from ..errors import InputError
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real

MOST_RUNS = 1_000_000


@dataclass(frozen=True)
class Sampling:
    """Draws from all distributions of a study together: points of a unit cube, an edge for each of them.

    ``sobol`` and ``latin_hypercube`` are those of ``scipy.stats.qmc``, scrambled by the seed. ``saltelli`` is the
    design from which variance-based sensitivities follow (A. Saltelli, Computer Physics Communications 145, 2002): with
    ``count`` base points and d distributions it has ``count`` (d + 2) runs.
    """

    count: int = quantity("", 2, MOST_RUNS, "the number of draws", default=64)
    method: Literal["sobol", "latin_hypercube", "random", "saltelli"] = "sobol"
    seed: int = quantity("", 0, 2**31 - 1, "the seed of the draws", default=1)

    def __post_init__(self) -> None:
        check(self)
        if self.method in ("sobol", "saltelli") and self.count & (self.count - 1):
            power = 1 << (self.count.bit_length() - 1)
            raise InputError(
                f"count = {self.count} is no power of two, and a {self.method} design needs one: give {power} or "
                f"{2 * power}"
            )

    def draws(self, dimensions: int) -> Real:
        """Points (runs, dimensions) in the unit cube; raises InputError if the design needs a library."""
        if self.method == "saltelli":
            return saltelli(dimensions, self.count, self.seed)
        random = np.random.default_rng(self.seed)
        if self.method == "random":
            return random.random((self.count, dimensions))
        from scipy.stats import qmc

        design = qmc.Sobol if self.method == "sobol" else qmc.LatinHypercube
        return np.asarray(design(dimensions, seed=random).random(self.count))


def problem(dimensions: int) -> dict[str, Any]:
    """The unit cube as SALib describes it."""
    names = [f"x{number}" for number in range(dimensions)]
    return {"num_vars": dimensions, "names": names, "bounds": [[0.0, 1.0]] * dimensions}


def saltelli(dimensions: int, count: int, seed: int) -> Real:
    """Points (count (dimensions + 2), dimensions) of the unit cube; raises InputError without SALib."""
    return np.asarray(_salib("sample.sobol").sample(problem(dimensions), count, calc_second_order=False, seed=seed))


def sobol_indices(values: Real, dimensions: int, seed: int) -> tuple[Real, Real]:
    """Sobol indices of first order and total ones, from values (runs,) at the points of ``saltelli``.

    Each is (dimensions, 2): the estimate, and half of its interval of 95 % by bootstrap. Raises InputError without
    SALib.
    """
    found = _salib("analyze.sobol").analyze(problem(dimensions), values, calc_second_order=False, seed=seed)
    first, total = (np.column_stack([found[kind], found[f"{kind}_conf"]]) for kind in ("S1", "ST"))
    return first, total


def _salib(module: str) -> Any:
    try:
        return import_module(f"SALib.{module}")
    except ModuleNotFoundError as missing:
        if missing.name != "SALib":
            raise
        raise InputError(
            "saltelli needs SALib, which is not installed: pip install SALib, or this package with the extra "
            "sensitivity"
        ) from None
