"""Mutated scenarios, models, studies and tables: each is read, or rejected in one line."""

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from support.mutants import MUTANTS, bounded, mutated_bytes, mutated_trees
from wheelset_track_sim.contact.profile_files import ProfileFile, read_points
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.tables import read_table
from wheelset_track_sim.inputs.yaml12 import dump, parse
from wheelset_track_sim.irregularities.listing import listed
from wheelset_track_sim.scenario import load_scenario, override, scenario_from
from wheelset_track_sim.studies import load_study
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.twin.measured.reading import read_measurement
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.vehicle import load_vehicle

pytestmark = [
    pytest.mark.fuzz,
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::wheelset_track_sim.errors.InputWarning"),
    pytest.mark.filterwarnings("ignore:Reading `.npy` or `.npz` file required additional header parsing:UserWarning"),
    pytest.mark.filterwarnings("ignore:Generating overly large repr"),  # of a failure, which it would hide
]
quiet = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=MUTANTS
)
CONFIG = files("wheelset_track_sim") / "data" / "config"
READERS: dict[str, Callable[[str], Any]] = {
    "scenarios": load_scenario,
    "studies": load_study,
    "tracks": load_track,
    "wheelsets": load_wheelset,
    "vehicles": load_vehicle,
}
TABLES = {
    "profile.csv": "y [mm],z [mm]\n"
    + "".join(f"{y},{0.001 * y * y - (20 if y > 30 else 0)}\n" for y in range(-60, 45, 5)),
    "tread.csv": "angle [deg];wheel_1 [um]\n" + "".join(f"{a};{10 * np.sin(a / 57):.3f}\n" for a in range(0, 360, 20)),
    "forces.csv": "# truth\ntime_s,force_wheel_1_N,force_wheel_2_N\n"
    + "".join(f"{n / 1000},{98_100 + n},{98_100 - n}\n" for n in range(30)),
    "stamped.csv": "time,Q left [kN];Q right [kN]\n".replace(",", ";")
    + "".join(f"2025-11-30T10:53:{20 + n}.5Z;{98.1 + n};{98.1 - n}\n" for n in range(30)),
    "wheel.prw": "header.begin\nunits.len.f = 1000\nunits.ang.f = 1\nrotate = 0.01\nbound.y.min = -70\n"
    "bound.y.max = 60\nheader.end\nspline.begin\npoint.begin\n"
    + "".join(f"{y} {0.001 * y * y - (20 if y > 30 else 0)} 0\n" for y in range(-60, 45, 5))
    + "point.end\nspline.end\n",
    "wheel.whl": "ProgramName=gauge\n\n"
    + "".join(f"{y}\t{0.001 * y * y - (20 if y > 30 else 0)}\t0\n" for y in range(-60, 45, 5)),
}
ARRAYS = {
    "modes.frequencies": np.array([85.0, 206.0]),
    "modes.lift": np.ones((2, 2)),
    "stress_nodes.0.name": np.array("A1"),
    "stress_nodes.0.modal": np.ones((2, 6)),
    "mass": np.array(1000.0),
}
"""A part of an imported wheelset."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def rejected_in_one_line(read: Callable[[Any], Any], given: Any) -> None:
    """Read, or an InputError whose text is one line and not longer than a screen."""
    try:
        with bounded():
            read(given)
    except InputError as refusal:
        text = str(refusal)
        assert text.strip()
        assert len(text) < 6000


@pytest.mark.parametrize("kind", READERS)
@quiet
@given(data=st.data())
def test_yaml(folder: Path, kind: str, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(set(shipped.names(kind)) - {"imported", "trailer_calculix"})))
    text = (CONFIG / kind / f"{name}.yaml").read_text()
    tree = data.draw(mutated_trees(parse(text, name)))
    try:
        changed = dump(tree)
    except Exception:  # noqa: BLE001  no YAML can hold it
        changed = repr(tree)
    path = folder / f"{kind}.yaml"
    path.write_bytes(data.draw(st.one_of(st.just(changed.encode()), mutated_bytes(text.encode()))))
    rejected_in_one_line(READERS[kind], str(path))


@quiet
@given(data=st.data())
def test_settings(data: st.DataObject) -> None:
    """What ``--set`` and lists of irregularities by service are given."""
    tree = parse((CONFIG / "scenarios" / "mixed.yaml").read_text(), "mixed")
    key = data.draw(
        st.one_of(
            st.sampled_from(["speed", "track.pad.stiffness", "loads", "irregularities.0.h", "wheelset", "a.b", ""]),
            st.lists(st.sampled_from(["irregularities", "0", "\u00b2", "9" * 5000, "-1", "track", "pad"])).map(
                ".".join
            ),
        )
    )
    value = data.draw(
        st.one_of(st.text(max_size=30), st.sampled_from(["[", "{a: 1}", "1e400", "&a [*a]", "!!python/x"]))
    )

    def read(change: str) -> None:
        override(tree, change)
        scenario_from(tree)

    rejected_in_one_line(read, f"{key}={value}")
    items = data.draw(mutated_trees(tree["irregularities"]))
    rejected_in_one_line(lambda text: listed(text, str), repr(items))


@pytest.mark.parametrize("name", TABLES)
@quiet
@given(data=st.data())
def test_tables(folder: Path, name: str, data: st.DataObject) -> None:
    path = folder / name
    path.write_bytes(
        data.draw(mutated_bytes(TABLES[name].encode(data.draw(st.sampled_from(["utf-8", "utf-16", "cp1252"])))))
    )
    rejected_in_one_line(read_table, path)
    rejected_in_one_line(read_measurement, path)
    for side in ("wheel", "rail"):
        rejected_in_one_line(lambda file, side=side: read_points(side, ProfileFile(file)), str(path))


@pytest.mark.parametrize("suffix", ["npz", "npy"])
@quiet
@given(data=st.data())
def test_arrays(folder: Path, suffix: str, data: st.DataObject) -> None:
    """Files of NumPy, packed or not: members renamed, of other types and shapes, heads and bytes changed."""
    path = folder / f"arrays.{suffix}"
    names = st.sampled_from([*ARRAYS, "mass.a", "modes", "stress_nodes.\u00b2.name", "a" + ".a" * 50, ""])
    values = st.sampled_from(
        [
            *ARRAYS.values(),
            np.zeros((3, 0)),
            np.array(["x"]),
            np.array([1 + 2j]),
            np.full((2, 2), np.nan),
            np.zeros(5, "i1"),
        ]
    )
    given = data.draw(st.dictionaries(names, values, max_size=5))
    np.savez(path, **ARRAYS | given) if suffix == "npz" else np.save(path, data.draw(values))
    content = path.read_bytes()
    shape = data.draw(st.sampled_from([b"(2, 2)", b"(9, 9)", b"(10000000000000, 2)", b"(-1, 2)"]))
    content = content.replace(b"(2, 2)", shape) if data.draw(st.booleans()) else content
    path.write_bytes(data.draw(st.one_of(st.just(content), mutated_bytes(content))))
    rejected_in_one_line(load_wheelset if suffix == "npz" else read_table, path)
