from __future__ import annotations

import numpy as np
import pytest

from wheelset_track_sim.wheelset.section_mesh import divided, grid, joined


def test_divided_keeps_breaks_and_middles() -> None:
    nodes = divided([0.0, 0.1, 0.25], 0.06)
    assert nodes == pytest.approx([0.0, 0.025, 0.05, 0.075, 0.1, 0.125, 0.15, 0.175, 0.2, 0.225, 0.25])


def test_blocks_that_touch_share_nodes() -> None:
    y = divided([0.0, 1.0], 0.5)
    lower = grid(y[:, None], divided([1.0, 2.0], 1.0)[None, :])
    upper = grid(y[:, None] + 1e-12, divided([2.0, 4.0], 1.0)[None, :])
    mesh = joined([lower, upper])
    assert mesh.elements.shape == (6, 8)
    # 3 columns x 4 rows of corners, 2 x 4 + 3 x 3 middles, no centres
    assert len(mesh.points) == 12 + 8 + 9
    assert mesh.elements.max() == len(mesh.points) - 1


def test_missing_node_is_refused() -> None:
    mesh = joined([grid(divided([0.0, 1.0], 1.0)[:, None], divided([1.0, 2.0], 1.0)[None, :])])
    assert mesh.points[mesh.nodes_on(np.array([[0.5, 1.0]]))] == pytest.approx(np.array([[0.5, 1.0]]))
    with pytest.raises(ValueError, match="no node"):
        mesh.nodes_on(np.array([[0.4, 1.0]]))
