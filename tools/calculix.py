"""Input and results of CalculiX: a body of revolution as 20-node bricks and 15-node wedges, and its result files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.wheelset.section_mesh import SectionMesh

Real = NDArray[np.float64]
Index = NDArray[np.int64]

STRESS_ORDER = [0, 1, 2, 3, 5, 4]
"""Of CalculiX's xx, yy, zz, xy, yz, zx as xx, yy, zz, xy, xz, yz."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Half of a body of revolution about y, from its bottom (-z) over the front (x > 0) to its top."""

    points: Real
    """(nodes, 3): x, y, z, m."""
    bricks: Index
    """(bricks, 20) in the order of C3D20R."""
    wedges: Index
    """(wedges, 15) in the order of C3D15, at the axis."""

    @property
    def count(self) -> int:
        """Number of elements."""
        return len(self.bricks) + len(self.wedges)

    def deck(self) -> Iterator[str]:
        """Lines of nodes and elements; all are in the set SOLID."""
        yield "*NODE, NSET=ALL"
        for number, (x, y, z) in enumerate(self.points, 1):
            yield f"{number}, {x:.12g}, {y:.12g}, {z:.12g}"
        number = 0
        for kind, elements in (("C3D20R", self.bricks), ("C3D15", self.wedges)):
            yield f"*ELEMENT, TYPE={kind}, ELSET=SOLID"
            for element in elements + 1:
                number += 1
                words = [str(number), *map(str, element)]
                yield ", ".join(words[:11]) + ",\n" + ", ".join(words[11:])


@dataclass(eq=False)
class Result:
    """Upward displacement and stress (xx, yy, zz, xy, xz, yz) by node of one mode or load case."""

    lift: dict[int, float] = field(default_factory=dict)
    stress: dict[int, Real] = field(default_factory=dict)


def revolved(mesh: SectionMesh, sectors: int) -> Solid:
    """Section revolved from theta = 0, the bottom, to pi, with ``sectors`` elements around the half."""
    angles = np.linspace(0.0, np.pi, 2 * sectors + 1)
    corner = np.isin(np.arange(len(mesh.points)), mesh.elements[:, :4])
    axis = mesh.points[:, 1] == 0.0
    used = np.ones((len(mesh.points), len(angles)), dtype=bool)
    used[axis, 1:] = False
    used[~corner, 1::2] = False
    numbers = np.full(used.shape, -1)
    numbers[used] = np.arange(used.sum())
    numbers[axis] = numbers[axis, :1]
    section, around = np.nonzero(used)
    y, r = mesh.points[section].T
    points = np.stack([r * np.sin(angles[around]), y, -r * np.cos(angles[around])], axis=1)
    points[np.abs(points) < 1e-12] = 0.0
    on_axis = axis[mesh.elements[:, 0]] & axis[mesh.elements[:, 1]]
    bricks, wedges = [], []
    for sector in range(sectors):
        here, half, there = (numbers[:, 2 * sector + place] for place in range(3))
        a = mesh.elements[~on_axis]
        # Counter-clockwise in (y, r) is clockwise seen from where theta grows: the far face comes first.
        faces = there[a[:, :4]], here[a[:, :4]], there[a[:, 4:]], here[a[:, 4:]], half[a[:, :4]]
        bricks.append(np.concatenate(faces, axis=1))
        b = mesh.elements[on_axis].T
        ends = here[b[0]], there[b[3]], here[b[3]], here[b[1]], there[b[2]], here[b[2]]
        middles = there[b[7]], half[b[3]], here[b[7]], there[b[5]], half[b[2]], here[b[5]]
        along = here[b[4]], there[b[6]], here[b[6]]
        wedges.append(np.stack([*ends, *middles, *along], axis=1))
    return Solid(points, np.concatenate(bricks), np.concatenate(wedges))


def frequencies_of(path: Path) -> Real:
    """Natural frequencies, Hz, from the table in a ``.dat`` file."""
    found = []
    for line in path.read_text(encoding="ascii").splitlines():
        if re.match(r"\s+\d+(\s+[-+.\dE]+){4}\s*$", line):
            words = line.split()
            if int(words[0]) != len(found) + 1:
                break  # the tables behind it
            found.append(float(words[3]))
    return np.array(found)


def results_of(path: Path) -> list[Result]:
    """Modes or load cases in their order from an ASCII ``.frd`` file: displacements and stresses at nodes."""
    results: list[Result] = []
    kind = ""
    with path.open(encoding="ascii") as lines:
        for line in lines:
            key = line[:5].strip()
            if key == "-4":
                kind = line.split()[1]
                if kind == "DISP":
                    results.append(Result())
            elif key == "-3":
                kind = ""
            elif key == "-1" and kind in ("DISP", "STRESS"):
                node = int(line[3:13]) - 1
                values = [float(line[start : start + 12]) for start in range(13, len(line.rstrip()), 12)]
                if kind == "DISP":
                    results[-1].lift[node] = values[2]
                else:
                    results[-1].stress[node] = np.array(values)[STRESS_ORDER]
    return results
