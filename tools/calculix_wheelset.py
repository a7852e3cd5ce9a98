"""A wheelset through CalculiX: bricks of its geometry, modes and static stresses by ``ccx``, and the file to import.

    .venv/bin/python -m tools.calculix_wheelset trailer --out trailer_calculix.yaml
    .venv/bin/wheelset-track-sim run undamaged --set wheelset=trailer_calculix.yaml --set output.stress_nodes=[A1,M]

An example for other programs, too: what they have to compute, in which units and signs, is in ``written``. CalculiX
(package ``calculix-ccx`` of Debian and Ubuntu) gets half of the wheelset, for vertical forces leave it symmetric about
the plane x = 0; so modal masses, which CalculiX norms to one for what it was given, are two for the whole.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.shipped import table_text
from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.wheelset.harmonics import GRAVITY, total_mass
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import stress_fillet, surface_radius, wheelset_mesh
from wheelset_track_sim.wheelset.section_mesh import RESOLUTION
from wheelset_track_sim.wheelset.wheelset import MeshSize, Wheelset

from .calculix import Result, Solid, frequencies_of, results_of, revolved

Real = NDArray[np.float64]

SIZE = MeshSize(axle=0.05, radial=0.045, fillet=0.008, attached=0.05)
SECTORS = 6
MODES = 40
OUTPUT = "*NODE FILE, NSET=WANTED\nU\n*EL FILE, NSET=WANTED\nS\n"
GRAVITY_STEP = f"*STEP\n*STATIC\n*CLOAD, OP=NEW\n*DLOAD\nSOLID, GRAV, {GRAVITY}, 0., 0., -1.\n{OUTPUT}*END STEP\n"
"""The wheelset hung up in its suspension under its own weight; axle boxes, which make no stress, are left out."""
LOWEST = 1.0
"""Hz; below is the motion along the axle, which no vertical force excites."""


def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("wheelset", help="name of a shipped wheelset, or a file of its geometry")
    parser.add_argument("--out", type=Path, required=True, help="file to write, YAML")
    parser.add_argument("--modes", type=int, default=MODES, help=f"number of modes ({MODES})")
    parser.add_argument("--ccx", default="ccx", help="the program (ccx)")
    given = parser.parse_args(arguments)
    try:
        content = by_calculix(load_wheelset(given.wheelset), modes=given.modes, ccx=given.ccx)
    except InputError as refusal:
        print(refusal, file=sys.stderr)
        return 2
    told = f"# {given.wheelset} by its modes from CalculiX, as tools/calculix_wheelset.py writes them. SI units.\n"
    given.out.write_text(told + as_yaml(content), encoding="utf-8")
    print(f"{given.out}: {len(content['modes']['frequencies'].split())} modes")
    return 0


def as_yaml(content: Mapping[str, Any], indent: str = "") -> str:
    """YAML of a mapping, with tables as they are read by people."""
    lines = []
    for key, item in content.items():
        if isinstance(item, str) and "\n" in item:
            lines += [f"{indent}{key}: |", *(f"{indent}  {line}" for line in item.splitlines())]
        elif isinstance(item, Mapping):
            lines += [f"{indent}{key}:", as_yaml(item, indent + "  ")]
        elif isinstance(item, list) and item and isinstance(item[0], Mapping):
            entries = (as_yaml(entry, indent + "    ") for entry in item)
            lines += [f"{indent}{key}:", *(f"{indent}  - {entry.lstrip()}" for entry in entries)]
        else:
            lines.append(f"{indent}{key}: {json.dumps(item)}")
    return "\n".join(line.rstrip("\n") for line in lines) + "\n"


def by_calculix(
    wheelset: Wheelset, *, size: MeshSize = SIZE, sectors: int = SECTORS, modes: int = MODES, ccx: str = "ccx"
) -> dict[str, Any]:
    """Content of the file that describes a wheelset by its modes; raises InputError if ``ccx`` fails."""
    solid = revolved(wheelset_mesh(wheelset, size), sectors)
    watched = _watched(wheelset, solid, size)
    with tempfile.TemporaryDirectory() as folder:
        free = _solved(Path(folder), "modes", _deck(wheelset, solid, watched, _frequency(modes)), ccx)
        steps = [*(_static(solid, wheelset, wheel) for wheel in range(2)), GRAVITY_STEP]
        loads = _deck(wheelset, solid, watched, "".join(steps))
        static = _solved(Path(folder), "static", loads, ccx)
        frequencies = frequencies_of(free.with_suffix(".dat"))
        shapes, statics = results_of(free.with_suffix(".frd")), results_of(static.with_suffix(".frd"))
    kept = [mode for mode, frequency in enumerate(frequencies) if frequency > LOWEST]
    return written(wheelset, solid, watched, frequencies[kept], [shapes[mode] for mode in kept], statics)


def written(
    wheelset: Wheelset,
    solid: Solid,
    watched: dict[str, list[int]],
    frequencies: Real,
    shapes: list[Result],
    statics: list[Result],
) -> dict[str, Any]:
    """What another program has to deliver: lifts at contacts and suspension, and stresses at nodes, in SI units."""
    omega, material = 2 * np.pi * frequencies, wheelset.material
    contacts = [_contact(solid, wheelset, wheel) for wheel in range(2)]
    boxes = [_bearing(solid, wheelset, wheel) for wheel in range(2)]
    nodes = []
    for node in wheelset.stress_nodes:
        # Of the nodes in a fillet, the one that is stressed most under equal loads.
        places = np.array(watched[node.name])
        both = np.array([sum(static.stress[place] for static in statics[:2]) for place in places])
        place = int(places[maximum_principal(both).argmax()])
        position = solid.points[place]
        nodes.append(
            {
                "name": node.name,
                "position": position.tolist(),
                "diameter": 2 * float(surface_radius(wheelset, position[1:2])[0]),
                "modal": table_text(np.array([shape.stress[place] for shape in shapes])),
                "static": table_text(np.array([static.stress[place] for static in statics[:2]])),
                "own_weight": statics[2].stress[place].tolist(),
            }
        )
    return {
        "imported": 1,
        "name": f"{wheelset.name}_calculix",
        "rolling_radius": wheelset.rolling_radius,
        "mass": total_mass(wheelset, wheelset_mesh(wheelset)),
        "contacts": [*wheelset.contact_positions],
        "suspension_damping": wheelset.axle_boxes.damping,
        "static_lift": table_text(np.array([[static.lift[place] for static in statics[:2]] for place in contacts])),
        "torque_places": [{"name": item.name, "y": item.y} for item in wheelset.equipment]
        + ([{"name": "gearbox", "y": wheelset.gearbox.y}] if wheelset.gearbox else []),
        "modes": {
            "frequencies": table_text(frequencies),
            "damping_ratios": table_text((material.mass_damping / omega + material.stiffness_damping * omega) / 2),
            "modal_masses": table_text(np.full(len(omega), 2.0)),
            "lift": table_text(np.array([[shape.lift[place] for place in contacts] for shape in shapes])),
            "suspension": table_text(
                np.array([[np.mean([shape.lift[place] for place in box]) for box in boxes] for shape in shapes])
            ),
        },
        "stress_nodes": nodes,
    }


def _watched(wheelset: Wheelset, solid: Solid, size: MeshSize) -> dict[str, list[int]]:
    """Nodes of the solid among which each stress node is found; raises InputError for one off the top."""
    found = {}
    for node in wheelset.stress_nodes:
        if node.angle:
            raise InputError(f"stress_nodes.{node.name}.angle = {node.angle:g} rad: give a node on the top")
        y = stress_fillet(wheelset, node, size)[:, 0] if node.y is None else np.array([node.y])
        r = surface_radius(wheelset, y)
        places = np.stack([0 * y, y, r], axis=1)
        distance = np.linalg.norm(solid.points[None] - places[:, None], axis=2)
        found[node.name] = sorted({int(nearest) for nearest in distance.argmin(axis=1)})
    return found


def _contact(solid: Solid, wheelset: Wheelset, wheel: int) -> int:
    """Node at the nominal contact point."""
    at = np.array([0.0, wheelset.contact_positions[wheel], -wheelset.rolling_radius])
    return int(np.linalg.norm(solid.points - at, axis=1).argmin())


def _bearing(solid: Solid, wheelset: Wheelset, wheel: int) -> list[int]:
    """Nodes of the journal's surface under the axle box, which carry it in equal parts."""
    boxes = wheelset.axle_boxes
    x, y, z = solid.points.T
    middle = boxes.distance * (2 * wheel - 1)
    radius = surface_radius(wheelset, np.array([middle]))[0]
    on = np.abs(np.hypot(x, z) - radius) < 1e-6
    return np.flatnonzero(on & (np.abs(y - middle) < boxes.bearing_length / 2 + RESOLUTION)).tolist()


def _deck(wheelset: Wheelset, solid: Solid, watched: dict[str, list[int]], steps: str) -> str:
    """Input of CalculiX: half a wheelset on half its suspension, and the steps."""
    material, boxes = wheelset.material, wheelset.axle_boxes
    lines = [*solid.deck()]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{material.youngs_modulus:.9g}, {material.poissons_ratio:.9g}"]
    lines += ["*DENSITY", f"{material.density:.9g}", "*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL"]
    lines += ["*BOUNDARY", *(f"{node + 1}, 1, 1" for node in np.flatnonzero(np.abs(solid.points[:, 0]) < 1e-9))]
    bearings = [_bearing(solid, wheelset, wheel) for wheel in range(2)]
    # Half of what is there, in equal parts; nodes in the plane of symmetry have half a neighbourhood.
    number = solid.count
    lines += _on_nodes(bearings, solid, number, "SUSPENSION", "SPRING1", 3, boxes.stiffness / 2)
    number += sum(map(len, bearings))
    if boxes.mass:
        lines += _on_nodes(bearings, solid, number, "BOXES", "MASS", 0, boxes.mass / 2)
        number += sum(map(len, bearings))
    axis = int(np.linalg.norm(solid.points, axis=1).argmin())
    lines += [f"*ELEMENT, TYPE=SPRING1, ELSET=ALONG\n{number + 1}, {axis + 1}", "*SPRING, ELSET=ALONG\n2", "1000."]
    wanted = {_contact(solid, wheelset, wheel) for wheel in range(2)}
    wanted |= {node for group in [*bearings, *watched.values()] for node in group}
    lines += ["*NSET, NSET=WANTED", *(f"{node + 1}," for node in sorted(wanted))]
    return "\n".join(lines) + "\n" + steps


def _on_nodes(
    groups: Iterable[list[int]], solid: Solid, number: int, name: str, kind: str, direction: int, total: float
) -> list[str]:
    """Elements of one node each, that share ``total`` within each group: those of the symmetry plane take half."""
    lines = []
    for group in groups:
        share = np.where(np.abs(solid.points[group, 0]) < 1e-9, 0.5, 1.0)
        for node, part in zip(group, total * share / share.sum(), strict=True):
            number += 1
            lines += [f"*ELEMENT, TYPE={kind}, ELSET={name}{number}\n{number}, {node + 1}"]
            if kind == "MASS":
                lines += [f"*MASS, ELSET={name}{number}\n{part:.9g}"]
            else:
                lines += [
                    f"*SPRING, ELSET={name}{number}\n{direction}\n{part:.9e}"
                ]  # what has a point is the stiffness
    return lines


def _frequency(modes: int) -> str:
    return f"*STEP\n*FREQUENCY\n{modes}\n{OUTPUT}*END STEP\n"


def _static(solid: Solid, wheelset: Wheelset, wheel: int) -> str:
    """1 N upwards on a wheel, half of it on the half."""
    load = f"*CLOAD, OP=NEW\n{_contact(solid, wheelset, wheel) + 1}, 3, 0.5\n"
    return f"*STEP\n*STATIC\n{load}{OUTPUT}*END STEP\n"


def _solved(folder: Path, name: str, deck: str, ccx: str) -> Path:
    """Path of the results without suffix; raises InputError if the program is missing or fails."""
    path = folder / name
    path.with_suffix(".inp").write_text(deck, encoding="ascii")
    try:
        done = subprocess.run([ccx, name], cwd=folder, capture_output=True, text=True, check=False)
    except OSError as reason:
        raise InputError(f"{ccx} cannot be run ({reason}): install calculix-ccx or give --ccx") from None
    if done.returncode or "*ERROR" in done.stdout or not path.with_suffix(".frd").exists():
        told = [line.strip() for line in done.stdout.splitlines() if "ERROR" in line] or done.stdout.splitlines()[-1:]
        raise InputError(f"{ccx} did not solve {name} ({' '.join(told[:2])}): look at its input")
    return path


if __name__ == "__main__":
    sys.exit(main())
