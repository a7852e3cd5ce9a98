import platform
import subprocess
import sys

import pytest

from wheelset_track_sim.runtime import memory

USE = """
import resource
import numpy as np
from wheelset_track_sim.runtime.memory import keep_freed_memory
{call}
def chunk():
    return [np.ones(50_000) for _ in range(8)]
chunk()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(50):
    chunk()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="of the GNU C library")
@pytest.mark.slow
def test_a_chunk_uses_the_memory_of_the_one_before() -> None:
    faults = [
        int(subprocess.run([sys.executable, "-c", USE.format(call=call)], capture_output=True, check=True).stdout)
        for call in ("", "keep_freed_memory()")
    ]
    assert faults[1] < 0.1 * faults[0]


def test_another_c_library_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory.ctypes, "CDLL", lambda name: object())
    memory.keep_freed_memory()
