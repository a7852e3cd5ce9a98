"""Content gone wrong: trees of values, text and bytes with pieces replaced, removed, moved or doubled."""

import copy
import resource
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st

MUTANTS = {20: 5, 100: 25}.get(settings.default.max_examples, settings.default.max_examples)
"""Mutants of each kind: few in the suite, all that the profile of ``make fuzz`` says."""
PROCESSOR_TIME = 10.0
"""Bound on an operation, s of processor."""
MEMORY = 1 << 30
"""Bound on what an operation takes beyond what the process has, bytes."""
FIGURES: dict[str, float] = {}
"""Of all operations of a test: their number, the slowest, s of processor, and the largest, bytes."""

NUMBERS = [-1, 0, 1, 2**31, 2**63, 2**64 - 1, 10**400, 1e308, -1e-320, float("inf"), float("nan"), True, None]
WORDS = [
    "",
    "x" * 5000,
    "../x",
    "a\0b",
    "\ud800",
    "\x9b31m",
    "a\nb",
    "9" * 5000,
    "\u00b2",
    "/dev/zero",
    "/etc/passwd",
    "\x1b[31m",
    "\u202e",
    "1e400",
    "2026-11-30",
    ".nan",
    "A1",
    "*a",
]
SHAPES = [[], {}, [[]], [None, None], {"a": {}}, {"": 1}, {"type": "flat"}, [1, 2, 3], [["x", 1e9]], {"name": "x40"}]
ODD = st.one_of(
    *(st.sampled_from(each) for each in (NUMBERS, WORDS, SHAPES)),
    st.floats(),
    st.integers(-10, 10),
    st.text(max_size=8),
)
PIECES = [
    b"\x00",
    b"\xff",
    b"1e400",
    b"1e999999",
    b";",
    b",",
    b"\t",
    b"\n",
    b'"',
    b"#",
    b"[",
    b"nan",
    b"-",
    b"\xb5m",
    b"0x1",
]


def places(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Ways to all values in a tree of mappings and lists."""
    yield path
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from places(value, (*path, key))
    elif isinstance(tree, list):
        for number, value in enumerate(tree[:20]):
            yield from places(value, (*path, number))


def _value(tree: Any, path: tuple[Any, ...]) -> Any:
    """Value at a place, or as near to it as there still is one."""
    try:
        for step in path:
            tree = tree[step]
    except (LookupError, TypeError):
        pass
    return tree


@st.composite
def mutated_trees(draw: st.DrawFn, tree: Any) -> Any:
    """A tree with one to three of its values replaced, removed, doubled, wrapped, or moved elsewhere."""
    found = copy.deepcopy(tree)
    for _ in range(draw(st.integers(1, 3))):
        ways = list(places(found))[1:]
        if not ways:
            return copy.deepcopy(draw(ODD))
        *path, last = draw(st.sampled_from(ways))
        place = found
        for step in path:
            place = place[step]
        value = place[last]
        how = draw(st.sampled_from(["replace", "replace", "remove", "wrap", "rename", "swap"]))
        if how == "remove":
            del place[last]
        elif how == "wrap":
            place[last] = draw(st.sampled_from([[value], {"value": value}, [value, value], str(value)]))
        elif how == "rename" and isinstance(place, dict):
            place[draw(st.sampled_from(["", "x", "name", "type", 7, str(last).upper()]))] = place.pop(last)
        elif how == "swap":
            other = _value(found, draw(st.sampled_from(ways)))
            place[last] = copy.deepcopy(other)
        else:
            place[last] = copy.deepcopy(draw(ODD))  # which may be changed in turn
    return found


@st.composite
def mutated_bytes(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes with one to five stretches overwritten, removed, doubled or inserted, or cut off."""
    found = bytearray(content)
    for _ in range(draw(st.integers(1, 5))):
        start = draw(st.integers(0, len(found)))
        length = draw(st.integers(0, 40))
        how = draw(st.sampled_from(["overwrite", "remove", "double", "insert", "cut"]))
        if how == "overwrite":
            found[start : start + length] = draw(st.binary(min_size=length, max_size=length))
        elif how == "remove":
            del found[start : start + length]
        elif how == "double":
            found[start:start] = found[start : start + length]
        elif how == "insert":
            found[start:start] = draw(st.sampled_from(PIECES)) * draw(st.integers(1, 3))
        else:
            del found[start:]
    return bytes(found)


@contextmanager
def bounded() -> Iterator[None]:
    """Fail what takes more processor time or memory than an input of its size may; ``FIGURES`` notes both."""

    def too_long(number: int, frame: Any) -> None:
        raise AssertionError(f"it took more than {PROCESSOR_TIME} s of processor")

    resting, before = _kilobytes("VmRSS"), resource.getrlimit(resource.RLIMIT_AS)
    Path("/proc/self/clear_refs").write_text("5")  # the largest size so far is that of now
    handler = signal.signal(signal.SIGPROF, too_long)
    resource.setrlimit(resource.RLIMIT_AS, (1024 * _kilobytes("VmSize") + 2 * MEMORY, before[1]))
    signal.setitimer(signal.ITIMER_PROF, PROCESSOR_TIME)
    begun = time.process_time()
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        took = time.process_time() - begun
        resource.setrlimit(resource.RLIMIT_AS, before)
        signal.signal(signal.SIGPROF, handler)
        grown = 1024 * (_kilobytes("VmHWM") - resting)
        FIGURES["operations"] = FIGURES.get("operations", 0) + 1
        FIGURES["slowest"] = max(FIGURES.get("slowest", 0.0), took)
        FIGURES["largest"] = max(FIGURES.get("largest", 0.0), grown)
        assert took < PROCESSOR_TIME  # though the operation may have caught the error above
        assert grown < MEMORY


def _kilobytes(name: str) -> int:
    """A size of this process, kB."""
    status = Path("/proc/self/status").read_text()
    return int(status[status.index(name) :].split(maxsplit=2)[1])
