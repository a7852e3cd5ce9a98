"""Writing a data set: passages that are there are kept, the others simulated; then labels and card."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from ..bags.exports import require_libraries
from ..errors import InputError, WheelsetTrackError
from ..inputs.schema import confirmed_numbers, plain, read
from ..inputs.yaml12 import dump
from ..runtime.arrays import Single
from ..runtime.cache import digest
from ..runtime.cores import cores
from ..runtime.progress import Progress
from ..simulation.models import load_models
from ..studies.conduct import Resources
from ..studies.workers import on_cluster, on_this_machine
from ..version import __version__
from .card import CARD, PAGE, card_of, page_of
from .labels import COLUMNS, Label, group, labels
from .passing import PEAKS, Passing, detector_position, program, signals_of, simulate, site
from .spec import DatasetSpec
from .store import ArrayPlan, ChunkStore, dumped

LABELS = "labels.parquet"
SPEC = "spec.yaml"
MOST_SAMPLES = 10_000_000

log = logging.getLogger(__name__)


def write_dataset(
    spec: DatasetSpec,
    out: str | Path,
    *,
    samples: int,
    seed: int = 1,
    resources: Resources | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Write a data set; one that was stopped goes on where it was. The bytes do not depend on the workers.

    Parameters
    ----------
    spec
        From ``load_spec``, or made in Python.
    out
        Folder of the data set, such as ``damage.zarr``.
    samples
        Number of samples; a wheelset has one in each passage of its train.
    seed
        Of everything that is drawn.
    resources
        Number of worker processes, or a Dask scheduler; one process a core if None.
    progress
        Called with stage and fraction.

    Returns
    -------
    dict
        The card.

    Raises
    ------
    InputError
        For a number or a folder that cannot be used, and without pyarrow.
    WheelsetTrackError
        If passages failed; all others are kept.
    """
    require_libraries("a data set", ("pyarrow",))
    if not 1 <= samples <= MOST_SAMPLES:
        raise InputError(f"samples = {samples} is out of range: give 1 to {MOST_SAMPLES}")
    if not 0 <= seed < 2**31:
        raise InputError(f"seed = {seed} is out of range: give 0 to {2**31 - 1}")
    store = store_of(spec, Path(out), samples, seed)
    store.begin()
    missing = [number for number in range(-(-samples // spec.wheelsets)) if not store.has(number)]
    passages = {number: Passing(spec, tuple(group(spec, seed, number, samples))) for number in missing}
    done = samples - sum(len(each.labels) for each in passages.values())
    failures: list[str] = []
    if missing:
        _build_models(passages[missing[0]], resources, progress)
    for number, ended in _simulated(passages, resources or Resources()):
        if isinstance(ended, Exception):
            failures.append(f"passage {number}: {' '.join(str(ended).split())}")
            log.error("%s", failures[-1])
        else:
            store.save(number, ended)
            done += len(passages[number].labels)
        if progress:
            progress(f"data set {store.folder.name}, {done} of {samples} samples", done / samples)
    if failures:
        raise WheelsetTrackError(
            f"{len(failures)} passages failed ({failures[0]}): the others are kept, run the command again"
        )
    return _finish(spec, store, samples, seed)


def store_of(spec: DatasetSpec, out: Path, samples: int, seed: int) -> ChunkStore:
    """Folder of a data set, with what tells it from others."""
    plans = {
        each.topic: ArrayPlan(
            (samples, len(each.channels), each.values),
            spec.wheelsets,
            ("sample", *(f"{dimension}_of_{each.topic.replace('/', '_')}" for dimension in ("channel", "time"))),
            {"channels": list(each.channels), "units": each.unit, "rate_Hz": each.rate},
        )
        for each in signals_of(spec)
    }
    plans[PEAKS] = ArrayPlan(
        (samples, 2), spec.wheelsets, ("sample", "wheel"), {"channels": ["wheel_1", "wheel_2"], "units": "N"}
    )
    attributes = {
        "title": spec.title,
        "licence": spec.licence,
        "samples": samples,
        "seed": seed,
        "wheelset_track_sim": __version__,
        "program": program(),
        "spec": digest(plain(spec)),
    }
    return ChunkStore(out, {name.replace("/", "_"): plan for name, plan in plans.items()}, attributes)


def rebuild(folder: str | Path, sample: int) -> dict[str, Single]:
    """Simulate one sample of a data set again, from its label alone.

    Parameters
    ----------
    folder
        The data set, which has to be complete.
    sample
        Its number, from 0.

    Returns
    -------
    dict
        Signals by array, (channels, values), and ``peak_force`` (2,); float32. The same version of the program makes
        the same bits.

    Raises
    ------
    InputError
        If the data set is not complete, or has no such sample.
    """
    spec, label = _spec_of(Path(folder)), _label_of(Path(folder), sample)
    arrays = simulate(Passing(spec, (label,)), program())
    return {name.replace("/", "_"): values[0] for name, values in arrays.items()}


def stored(folder: str | Path, sample: int) -> dict[str, Single]:
    """What a data set has of a sample, in the form of ``rebuild``; raises InputError likewise."""
    spec, label = _spec_of(Path(folder)), _label_of(Path(folder), sample)
    card = json.loads((Path(folder) / CARD).read_text(encoding="utf-8"))
    store = store_of(spec, Path(folder), card["samples"], card["seed"])
    chunk, row = divmod(label.sample, spec.wheelsets)
    return {name: store.load(name, chunk)[row] for name in store.plans}


def _spec_of(folder: Path) -> DatasetSpec:
    try:
        card = json.loads((folder / CARD).read_text(encoding="utf-8"))
    except OSError as reason:
        raise InputError(f"{folder} is no complete data set ({reason.strerror}): give one with a {CARD}") from None
    with confirmed_numbers():
        return read(DatasetSpec, card["spec"], "")


def _label_of(folder: Path, sample: int) -> Label:
    require_libraries("a data set", ("pyarrow",))
    from pyarrow import parquet

    table = parquet.read_table(folder / LABELS, columns=list(COLUMNS))
    if not 0 <= sample < len(table):
        raise InputError(f"sample = {sample} is out of range: {folder} has the samples 0 to {len(table) - 1}")
    (row,) = table.slice(sample, 1).to_pylist()
    return Label(**row)


def _build_models(passing: Passing, resources: Resources | None, progress: Progress | None) -> None:
    """Once for all: workers of this machine then find most of the models in the cache."""
    if resources is None or resources.scheduler is None:
        load_models(site(passing.spec, passing.labels[0]), progress, tables="smooth")


def _simulated(
    passages: Mapping[int, Passing], resources: Resources
) -> Iterator[tuple[int, dict[str, Single] | Exception]]:
    if not passages:
        return iter(())
    work = partial(_by_array, made_for=program())
    if resources.scheduler is not None:
        return on_cluster(work, passages, resources.scheduler)
    return on_this_machine(work, passages, min(resources.workers or cores(), len(passages)))


def _by_array(passing: Passing, made_for: str) -> dict[str, Single]:
    """Arrays under the names that they have in the store."""
    return {name.replace("/", "_"): values for name, values in simulate(passing, made_for).items()}


def _finish(spec: DatasetSpec, store: ChunkStore, samples: int, seed: int) -> dict[str, Any]:
    """Write labels and card of a data set whose samples are there."""
    import pyarrow
    from pyarrow import parquet

    found = list(labels(spec, seed, samples))
    peaks = np.concatenate([store.load(PEAKS, chunk) for chunk in range(-(-samples // spec.wheelsets))])
    columns: dict[str, Any] = {name: [getattr(label, name) for label in found] for name in COLUMNS}
    columns |= {f"{PEAKS}_{wheel + 1}": peaks[:, wheel] for wheel in range(2)}
    if (detector := spec.detector) is not None:
        columns["detector_position"] = [detector_position(spec, detector, label) for label in found]
    units = {"units": json.dumps(UNITS), "title": spec.title, "licence": spec.licence}
    table = pyarrow.table(columns).replace_schema_metadata(units)
    temporary = store.folder / f"{LABELS}.tmp"
    try:
        parquet.write_table(table, temporary, compression="zstd")
        temporary.replace(store.folder / LABELS)
    except OSError as reason:
        raise WheelsetTrackError(f"{store.folder / LABELS} cannot be written ({reason.strerror})") from None
    versions = {"numpy": np.__version__, "scipy": scipy.__version__, "pyarrow": pyarrow.__version__}
    card = card_of(spec, store, columns, {"wheelset_track_sim": __version__} | versions)
    card |= {"samples": samples, "seed": seed, "failed": int(np.isnan(peaks).any(axis=1).sum())}
    store.write_text(SPEC, dump(plain(spec)))
    store.write_text(PAGE, page_of(card))
    store.write_text(CARD, dumped(card))
    return card


UNITS = (
    dict.fromkeys(("length", "worn_length", "a", "b", "h", "y", "joint_position", "detector_position"), "m")
    | {"angle": "rad", "speed": "m/s", "axle_load": "N", "wheel_roughness": "dB", "rail_roughness": "dB"}
    | {"joint_dip_angle": "rad", f"{PEAKS}_1": "N", f"{PEAKS}_2": "N"}
)
"""Units of the columns of the labels that have one."""
