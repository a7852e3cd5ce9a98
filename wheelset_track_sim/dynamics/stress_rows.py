"""Which stress components a run keeps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..inputs.schema import unknown
from ..wheelset.reduced import ReducedWheelset


def stress_rows(wheelset: ReducedWheelset, nodes: Sequence[str]) -> tuple[list[int], NDArray[np.intp]]:
    """Indices of stress nodes, and which of their components, (nodes, 6) flattened, are not zero by symmetry."""
    for index, node in enumerate(nodes):
        if node not in wheelset.node_names:
            where = f"output.stress_nodes.{index} = {node!r}"
            raise InputError(unknown("stress node of this wheelset", where, node, wheelset.node_names))
    rows = [wheelset.node_names.index(node) for node in nodes]
    shapes = np.abs(wheelset.stress_outputs[rows]).max(axis=-1, initial=0.0) * np.abs(wheelset.inputs).max()
    size = (shapes + np.abs(wheelset.stress_feedthrough[rows]).max(axis=-1, initial=0.0)).ravel()
    return rows, np.flatnonzero(size > 1e-9 * size.max(initial=0.0))
