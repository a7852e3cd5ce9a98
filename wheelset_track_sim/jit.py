"""One decorator for compiled kernels, with a cache on disk that cannot go stale.

Numba's cache notices an edit of the file a function stands in, not of a file whose functions it calls. So the cache
folder carries a digest of every kernel source in the package: an edit anywhere compiles anew. All compiled functions
stand in modules named ``*kernels.py``; that is what the digest covers.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs

config: Any = numba.config
Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def cache_folder() -> Path:
    """Folder of compiled kernels, named by a digest of their sources and of numba's version."""
    package = Path(__file__).parent
    digest = hashlib.blake2b(numba.__version__.encode(), digest_size=8)
    for source in sorted(package.rglob("*kernels.py")):
        digest.update(source.relative_to(package).as_posix().encode())
        digest.update(source.read_bytes())
    base = Path(config.CACHE_DIR or platformdirs.user_cache_path("wheelset_track_sim"))
    return base / "kernels" / digest.hexdigest()


def kernel(function: Function) -> Function:
    """Compile a function with numba: cached on disk, without the interpreter lock, NaN kept (no ``fastmath``)."""
    return _compiled(function, fastmath=False)


def summing_kernel(function: Function) -> Function:
    """``kernel`` whose sums may be reordered and contracted, so that they run in vector registers; NaN is kept."""
    return _compiled(function, fastmath={"reassoc", "contract", "nsz"})


def _compiled(function: Function, fastmath: bool | set[str]) -> Function:
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder())
    try:
        compiled = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=fastmath)(function)
        return cast(Function, compiled)
    finally:
        config.CACHE_DIR = previous
