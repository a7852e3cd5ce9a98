"""Digest of the program that makes a result: a module and every module that it imports, directly or through others.

The imports are read from the source files, so that no caller can forget one. A module depends on each module of its own
program that one of its import statements names, at the top of the file or in a function. Imports under ``if
TYPE_CHECKING`` are never executed and do not count. The ``__init__`` of a package counts if a name is imported from it,
not if only a module below it is. Modules whose names are put together at run time are not found.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import scipy

from ..version import __version__

PACKAGE = __name__.partition(".")[0]


@cache
def program(module: str) -> str:
    """Digest of a module, of all that it imports, and of the versions of this package, NumPy and SciPy.

    Imports are followed within this package and within the top-level package of ``module``. Files are read once a
    process. Raises ValueError for a module without a source file.
    """
    return digest_of(closure(module, {top: _folder(top) for top in (PACKAGE, module.partition(".")[0])}))


@cache
def whole_package() -> str:
    """Digest of all modules of this package and of the same versions."""
    folder = _folder(PACKAGE)
    paths = (folder / PACKAGE).rglob("*.py")
    return digest_of({path.relative_to(folder).as_posix(): path.read_bytes() for path in paths})


def digest_of(sources: Mapping[str, bytes]) -> str:
    """Digest of source files by module, and of the versions of this package, NumPy and SciPy."""
    hashed = hashlib.blake2b(json.dumps([__version__, np.__version__, scipy.__version__]).encode(), digest_size=16)
    for module in sorted(sources):
        hashed.update(f"{module} {hashlib.blake2b(sources[module]).hexdigest()}\n".encode())
    return hashed.hexdigest()


def closure(module: str, folders: Mapping[str, Path]) -> dict[str, bytes]:
    """Source, by module, of ``module`` and of all that it imports, itself or through others.

    Imports are followed within the top-level packages in ``folders``, each given with the folder that it is in. Raises
    ValueError if ``module`` has no source file.
    """
    found: dict[str, bytes] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = None if name in found else source_file(name, folders)
        if path is not None:
            found[name] = path.read_bytes()
            package = name if path.name == "__init__.py" else name.rpartition(".")[0]
            waiting += imports(found[name], package, folders)
    if not found:
        raise ValueError(f"module {module} has no source file: give a module of a package that is installed as files")
    return found


def imports(source: bytes, package: str, folders: Mapping[str, Path]) -> Iterator[str]:
    """Modules of the packages in ``folders`` that a module of ``package`` imports when it is executed."""
    for level, base, names in _import_statements(source):
        if level:
            parents = package.split(".")
            base = ".".join([*parents[: len(parents) - level + 1], *filter(None, [base])])
        within = [name for name in (f"{base}.{name}" for name in names) if source_file(name, folders)]
        yield from within
        if (len(within) < len(names) or not names) and source_file(base, folders):
            yield base


def source_file(module: str, folders: Mapping[str, Path]) -> Path | None:
    """File of a module of the packages in ``folders``; None if there is none."""
    folder = folders.get(module.partition(".")[0])
    if folder is None:
        return None
    # Called for every imported name: strings are several times as fast as paths.
    path = f"{folder}/{module.replace('.', '/')}"
    return next((Path(file) for file in (f"{path}.py", f"{path}/__init__.py") if os.path.isfile(file)), None)  # noqa: PTH113


@cache
def _import_statements(source: bytes) -> list[tuple[int, str, tuple[str, ...]]]:
    """Level, module and names of each import statement that can be executed."""
    found = []
    for item in _executed(ast.parse(source).body):
        if isinstance(item, ast.ImportFrom):
            found.append((item.level, item.module or "", tuple(name.name for name in item.names)))
        else:
            found += [(0, name.name, ()) for name in item.names]
    return found


def _executed(body: Iterable[ast.AST]) -> Iterator[ast.Import | ast.ImportFrom]:
    for item in body:
        if isinstance(item, (ast.Import, ast.ImportFrom)):
            yield item
        elif isinstance(item, ast.If) and "TYPE_CHECKING" in (getattr(item.test, name, "") for name in ("id", "attr")):
            yield from _executed(item.orelse)
        else:
            for inner in ("body", "handlers", "orelse", "finalbody", "cases"):
                yield from _executed(getattr(item, inner, ()))


def _folder(top: str) -> Path:
    """Folder that a top-level package or module is in."""
    spec = find_spec(top)
    if spec is not None and spec.submodule_search_locations:
        return Path(next(iter(spec.submodule_search_locations))).parent
    if spec is not None and spec.origin:
        return Path(spec.origin).parent
    raise ValueError(f"module {top} has no source file: give a module of a package that is installed as files")
