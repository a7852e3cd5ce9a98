import ast
from pathlib import Path

import numpy as np

import wheelset_track_sim
from wheelset_track_sim.runtime import jit

PACKAGE = Path(wheelset_track_sim.__file__).parent


def test_compiled_functions_stand_where_the_cache_digest_looks() -> None:
    for path in PACKAGE.rglob("*.py"):
        names = {
            getattr(decorator, "id", getattr(getattr(decorator, "func", None), "id", ""))
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.FunctionDef)
            for decorator in node.decorator_list
        }
        if names & {"kernel", "inner_kernel", "summing_kernel", "njit", "jit", "overload"}:
            assert path.name.endswith("kernels.py"), path


def test_the_cache_folder_follows_the_kernels(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "runtime" / "jit.py"))
    (tmp_path / "runtime").mkdir()
    (tmp_path / "runtime" / "jit.py").write_text("options")
    (tmp_path / "sub").mkdir()
    kernels = tmp_path / "sub" / "some_kernels.py"
    found = set()
    for text in ("one", "two"):
        kernels.write_text(text)
        jit.cache_folder.cache_clear()
        found.add(jit.cache_folder())
    (tmp_path / "runtime" / "jit.py").write_text("other options")
    jit.cache_folder.cache_clear()
    found.add(jit.cache_folder())
    jit.cache_folder.cache_clear()
    assert len(found) == 3


def test_nan_survives_a_reordered_sum() -> None:
    from wheelset_track_sim.dynamics.paper_kernels import _convolution

    green, past = np.ones(64), np.ones(64)
    past[40] = np.nan
    assert np.isnan(_convolution(green, past, 63))
