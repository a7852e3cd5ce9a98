import ast
import shutil
from pathlib import Path

import pytest

from support.paths import ROOT
from wheelset_track_sim.runtime import sources

PACKAGE = "wheelset_track_sim"
BUILDERS = [
    f"{PACKAGE}.{name}"
    for name in (
        "contact.tables",
        "dynamics.moving_green_functions",
        "studies.evaluate",
        "track.balance",
        "track.ring",
        "wheelset.reduction",
    )
]
"""Modules that keep models with ``cached``, and the one that runs a study."""


def modules(folder: Path) -> dict[str, Path]:
    """Files of the package in ``folder``, by module."""
    found = {}
    for path in (folder / PACKAGE).rglob("*.py"):
        parts = path.relative_to(folder).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@pytest.mark.slow
def test_all_builders_are_listed() -> None:
    calls = {
        name
        for name, path in modules(ROOT).items()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "cached"
    }
    assert calls | {f"{PACKAGE}.studies.evaluate"} == set(BUILDERS)


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(ROOT / PACKAGE, folder / PACKAGE, ignore=shutil.ignore_patterns("__pycache__", "data"))
    return folder


@pytest.mark.parametrize(
    "builder", [pytest.param(name, marks=pytest.mark.slow if "studies" in name else ()) for name in BUILDERS]
)
def test_an_edit_changes_the_digest_where_it_can_change_the_model(builder: str, copied: Path) -> None:
    folders, files = {PACKAGE: copied}, modules(copied)

    def digest() -> str:
        return sources.digest_of(sources.closure(builder, folders))

    before, needed = digest(), set(sources.closure(builder, folders))
    assert builder in needed
    for name in needed:
        original = files[name].read_text()
        files[name].write_text(f"{original}# edited\n")
        assert digest() != before, name
        files[name].write_text(original)
    others = {files[name]: files[name].read_text() for name in set(files) - needed}
    assert others
    for path, original in others.items():
        path.write_text(f"{original}# edited\n")
    assert digest() == before
    for path, original in others.items():
        path.write_text(original)


@pytest.mark.parametrize(
    ("builder", "needed"),
    [
        ("wheelset.reduction", "wheelset.mesh wheelset.harmonics samples.principal_kernels runtime.one_core"),
        ("track.balance", "track.ring track.bay track.supports track.timoshenko runtime.cache"),
        ("dynamics.moving_green_functions", "track.bay track.bloch track.timoshenko dynamics.green_functions"),
        ("contact.tables", "contact.path_kernels contact.active_set_kernels runtime.jit"),
        ("studies.evaluate", "simulation.coupled_kernels irregularities.flat scenario.loads studies.outputs"),
    ],
)
def test_models_depend_on_what_makes_them(builder: str, needed: str) -> None:
    found = sources.closure(f"{PACKAGE}.{builder}", {PACKAGE: ROOT})
    assert {f"{PACKAGE}.{name}" for name in needed.split()} <= set(found)


def test_models_do_not_depend_on_the_shell() -> None:
    shell = ("bags", "live", "monitoring", "twin", "report", "ros", "cli")
    for builder in BUILDERS:
        assert not [
            name for name in sources.closure(builder, {PACKAGE: ROOT}) if name.split(".")[1:2] in map(list, shell)
        ]


SMALL = {
    "small/__init__.py": "from . import unused",
    "small/unused.py": "",
    "small/builder.py": """
from __future__ import annotations
from typing import TYPE_CHECKING
import json, small.named
from . import beside
from .inner import value
from .inner.deep import thing
if TYPE_CHECKING:
    from .types_only import Type
else:
    from .otherwise import Type
def build():
    try:
        from .late import value
    except ImportError:
        from .later import value
    match value:
        case 1:
            from .matched import value
""",
    "small/named.py": "",
    "small/beside.py": "from .builder import build  # a circle",
    "small/inner/__init__.py": "from .reexported import value",
    "small/inner/reexported.py": "from ..above import value",
    "small/inner/deep.py": "from small.absolute import thing",
    "small/types_only.py": "",
} | {f"small/{name}.py": "" for name in ("otherwise", "late", "later", "matched", "above", "absolute")}


def test_imports_are_followed_wherever_they_are_executed(tmp_path: Path) -> None:
    for name, text in SMALL.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    found = sources.closure("small.builder", {"small": tmp_path})
    expected = "builder named beside inner inner.reexported inner.deep otherwise late later matched above absolute"
    assert set(found) == {f"small.{name}" for name in expected.split()}


def test_versions_are_part_of_a_digest(monkeypatch: pytest.MonkeyPatch) -> None:
    found = {sources.digest_of({"a": b""})}
    for owner in (sources, sources.np, sources.scipy):
        with monkeypatch.context() as other:
            other.setattr(owner, "__version__", "0")
            found.add(sources.digest_of({"a": b""}))
    assert len(found) == 4


def test_a_module_without_a_file_is_refused() -> None:
    with pytest.raises(ValueError, match=r"module builtins has no source file: give a module"):
        sources.program("builtins")
