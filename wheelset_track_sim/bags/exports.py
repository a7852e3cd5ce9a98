"""Recordings as files of tables: CSV, Excel, Parquet, NetCDF; the suffix says which.

All hold SI numbers, every bit of them but for Excel, which has 16 digits. CSV, Excel and Parquet have a row for each
step; the headings of CSV and Excel have the units, and CSV is read by ``compare`` and ``stress`` again. NetCDF has the
arrays of ``Recording.to_xarray``.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from ..errors import InputError, warn
from .frames import columns_of, dataframe, dataset, origin, sensors_apart
from .run_arrays import Recording, read_bag

MOST_ROWS = 2**20 - 1
"""Steps that an Excel sheet holds below its headings."""


class Form(NamedTuple):
    """A form of table."""

    write: Callable[[Recording, Path], None]
    needs: tuple[str, ...] = ()
    """Libraries that are no dependency of this package."""
    most: int | None = None
    """Steps that it holds."""
    of_steps: bool = True
    """Whether it has a row for each step and nothing else."""


def form_of(path: Path) -> Form | None:
    """Form that the suffix of a path names; None for a bag, which ends in ``.mcap`` or has no suffix.

    Raises InputError for another suffix, a form whose library is not installed, and a file that exists already.
    """
    suffix = path.suffix.lower()
    if suffix in ("", ".mcap"):
        return None
    form = FORMS.get(suffix)
    if form is None:
        raise InputError(
            f"--out {path} ends in {path.suffix}, which is not a supported format: give a name that ends in .mcap, "
            f"{', '.join(FORMS)}, or one without a suffix for a bag folder"
        )
    require_libraries(f"--out {path}", form.needs)
    _require_new(path)
    return form


def require_libraries(option: str, libraries: Iterable[str]) -> None:
    """Raise InputError, which begins with ``option``, for the first library that is not installed."""
    for library in libraries:
        if find_spec(library) is None:
            raise InputError(
                f"{option} needs {library}, which is not installed: pip install {library}, or this package with the "
                "extra analysis"
            )


def check_steps(path: Path, form: Form, steps: int) -> None:
    """Raise InputError if a form cannot hold that many steps."""
    if form.most is not None and steps > form.most:
        raise InputError(
            f"--out {path} would have {steps} rows, and {path.suffix} files hold at most {form.most}: give .csv, "
            ".parquet or .nc, or a shorter --duration"
        )


@contextmanager
def exported(path: Path, form: Form) -> Iterator[Path]:
    """Path of a bag to record within, of which a table is made at the end; raises InputError as ``form_of`` does."""
    try:
        folder = TemporaryDirectory(prefix=f".{path.stem}_", dir=path.absolute().parent)
    except OSError as reason:
        raise InputError(f"{path} cannot be written ({reason.strerror}): give another path") from None
    with folder as within:
        bag = Path(within) / "run.mcap"
        yield bag
        export(read_bag(bag), path, form)


def export(recording: Recording, path: Path, form: Form) -> None:
    """Write a recording as a table, whole or not at all; raises InputError for a file that exists."""
    check_steps(path, form, len(recording))
    apart = sensors_apart(recording) if form.of_steps else []
    if apart:
        warn(
            f"{path.name} has a row for each step, so {', '.join(apart)} with a sampling rate of their own are not in "
            "it: give .nc, or record a bag"
        )
    temporary = path.with_name(f"{path.stem}.part{path.suffix}")
    try:
        form.write(recording, temporary)
        _require_new(path)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _require_new(path: Path) -> None:
    if path.exists():
        raise InputError(f"{path} exists already: give another path, or remove it first")


def _rows(recording: Recording) -> Iterator[tuple[Any, ...]]:
    """Headings with units, then a row of plain numbers for each step."""
    columns, units = columns_of(recording)
    yield tuple(f"{name} [{units[name]}]" if units[name] else name for name in columns)
    yield from zip(*(column.tolist() for column in columns.values()), strict=True)


def _write_csv(recording: Recording, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(_rows(recording))


def _write_excel(recording: Recording, path: Path) -> None:
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    run, about = book.create_sheet("run"), book.create_sheet("about")
    run.freeze_panes = "B2"
    for row in _rows(recording):
        run.append(row)
    for name, value in origin(recording).items():
        about.append((name, str(value)))
    book.save(path)


def _write_parquet(recording: Recording, path: Path) -> None:
    dataframe(recording).to_parquet(path, engine="pyarrow")


def _write_netcdf(recording: Recording, path: Path) -> None:
    found = dataset(recording)
    # NetCDF 3, which scipy writes, has no whole numbers of 64 bits.
    found.attrs = {name: str(value) for name, value in found.attrs.items()}
    found.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")


FORMS = {
    ".csv": Form(_write_csv),
    ".parquet": Form(_write_parquet, ("pandas", "pyarrow")),
    ".xlsx": Form(_write_excel, ("openpyxl",), MOST_ROWS),
    ".nc": Form(_write_netcdf, ("xarray",), of_steps=False),
}
"""Forms of tables by suffix."""
