"""Set up .venv: ROS 2 Jazzy, the package with what it needs, and the built messages.

    python3 tools/setup_env.py [EXTRA ...]      extras of setup.cfg: test, dev

A sourced ROS 2 Jazzy is used; without one it comes from PyPI. Each step leaves a stamp with a digest of what it
depends on, so that a second call has nothing to do, and a call after a failure goes on where it stopped.
Runs on any Python 3: it looks for one that the package supports. Standard library only.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
STAMPS = VENV / ".setup"
ALWAYS = {"report"}
"""Extras that `make demo` needs."""
LOG = VENV / "setup.log"
SUPPORTED = ((3, 12), (3, 11), (3, 13), (3, 10))
PROBE = """
import importlib.util, json, os, sys, sysconfig
print(json.dumps({
    "version": list(sys.version_info[:2]), "ensurepip": importlib.util.find_spec("ensurepip") is not None,
    "headers": os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")),
    "include": sysconfig.get_path("include"), "site": sysconfig.get_path("purelib"),
    "rclpy": importlib.util.find_spec("rclpy") is not None}))
"""
LIBRARY_PATH = (
    'import os, sys; paths = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep); '
    'lib = os.path.join(sys.prefix, "lib"); lib in paths or os.execve(sys.executable, sys.orig_argv, '
    '{**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(filter(None, [lib, *paths]))})\n'
)
"""A line for a .pth file: the loader finds the built messages' libraries in .venv/lib without anything sourced."""


class SetupError(Exception):
    """A step failed; the message says what to do."""


def main(extras: list[str]) -> int:
    """Run all steps that are due; 0, or 1 after a message of what to do."""
    with Path(__file__).open() as lock:  # two calls at a time: the second waits for the first
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            set_up(extras)
        except SetupError as reason:
            print(f"setup: {reason}", file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            print("\nsetup: interrupted: call again to go on", file=sys.stderr)
            return 1
    return 0


def set_up(extras: list[str]) -> None:
    """Environment, packages, messages: each if it is missing or out of date."""
    sourced = sourced_ros()
    inside = environment(sourced)
    packages(extras, sourced)
    messages(inside, sourced)


def sourced_ros() -> bool:
    """Whether a ROS 2 Jazzy is sourced; another distribution is refused, for the two would mix."""
    distribution = os.environ.get("ROS_DISTRO", "")
    if distribution not in ("", "jazzy"):
        raise SetupError(f"ROS 2 {distribution} is sourced, Jazzy is needed: use a shell that sources Jazzy or none")
    if not distribution and (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        raise SetupError(
            f"ROS 2 comes from PyPI for Linux on x86-64 only, this is {platform.system()} on {platform.machine()}: "
            "install ROS 2 Jazzy, source its setup.bash, and call again"
        )
    return bool(distribution)


def interpreter(sourced: bool) -> tuple[str, dict]:
    """First Python that is supported, by path and what it says of itself."""
    names = [sys.executable, *(f"python{major}.{minor}" for major, minor in SUPPORTED), "/usr/bin/python3"]
    seen = []
    for name in names:
        path = shutil.which(name)
        found = probe(path) if path else None
        if not found:
            continue
        seen.append("{} ({}.{})".format(path, *found["version"]))
        if tuple(found["version"]) in SUPPORTED and (found["rclpy"] or not sourced):
            return str(path), found
    if sourced:
        raise SetupError(
            f"ROS 2 Jazzy is sourced, but none of {', '.join(seen)} finds its rclpy: "
            "call make PYTHON=/usr/bin/python3, or use a shell without ROS to take it from PyPI"
        )
    raise SetupError(
        f"Python 3.10, 3.11, 3.12 or 3.13 is needed, found {', '.join(seen)}: install one, call make PYTHON=python3.12"
    )


def probe(python: str) -> dict | None:
    """What a Python says of itself; None if it does not run."""
    try:
        said = subprocess.run(
            [python, "-c", PROBE], capture_output=True, text=True, timeout=60, env=plain_environment()
        )
        return json.loads(said.stdout) if said.returncode == 0 else None
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None


def environment(sourced: bool) -> dict:
    """What the Python of .venv says of itself; a fresh .venv if there is none, or one of another place or ROS.

    One that is there keeps its Python, whichever called this.
    """
    own = str(VENV / "bin" / "python")
    where = (str(VENV), sourced, os.environ.get("AMENT_PREFIX_PATH", "") if sourced else "")
    inside = probe(own)
    if inside and stamped("environment", digest(where, inside["version"])):
        return inside
    python, found = interpreter(sourced)
    version = "{}.{}".format(*found["version"])
    missing = {
        f"python{version}-venv": not found["ensurepip"],
        f"python{version}-dev": not found["headers"],
        "build-essential": not all(
            shutil.which((os.environ.get(name) or tool).split()[0])
            for name, tool in (("CC", "cc"), ("CXX", "c++"), ("MAKE", "make"))
        ),
    }
    if any(missing.values()):
        needed = " ".join(package for package, absent in missing.items() if absent)
        raise SetupError(
            f"{python} lacks its venv module or headers, or there is no C/C++ compiler: on Debian and Ubuntu "
            f"sudo apt install {needed}"
        )
    shutil.rmtree(VENV, ignore_errors=True)
    options = ["--system-site-packages"] if sourced else []
    VENV.mkdir()
    run(f"create .venv (Python {version})", [python, "-m", "venv", *options, str(VENV)], "see its last lines above")
    inside = probe(own)
    if not inside:
        raise SetupError(f"{own} does not run: see whether {python} works, and call again")
    if sourced:
        (Path(inside["site"]) / "wheelset_track_msgs.pth").write_text(LIBRARY_PATH)
    stamp("environment", digest(where, inside["version"]))
    return inside


def packages(extras: list[str], sourced: bool) -> None:
    """ROS 2, what builds messages, and this package with its extras, in one resolution."""
    name = "packages"
    sources = [ROOT / "setup.cfg", ROOT / "setup.py", ROOT / "requirements"]
    before = read_stamp(name)
    wanted = sorted({*ALWAYS, *extras, *before.get("extras", [])})
    key = digest(*sources, sourced)
    if before.get("key") == key and wanted == before["extras"]:
        return
    requirements = ["message-build.txt"] + ([] if sourced else ["ros-jazzy.txt"])
    arguments = [item for name_ in requirements for item in ("-r", str(ROOT / "requirements" / name_))]
    if sourced:  # the installed messages are compiled against the system's NumPy
        version = subprocess.run(
            [pip()[0], "-c", "import numpy; print(numpy.__version__)"], capture_output=True, text=True
        )
        arguments += [f"numpy=={version.stdout.strip()}"] if version.returncode == 0 else []
    target = f"{ROOT}[{','.join(wanted)}]" if wanted else str(ROOT)
    what = "Python packages" if sourced else "ROS 2 Jazzy and Python packages"
    run(
        f"install {what}" + (f" ({', '.join(wanted)})" if wanted else ""),
        [*pip(), "install", "--no-input", "--disable-pip-version-check", *arguments, "--editable", target],
        "check the network and pip's index settings, then call again",
    )
    stamp(name, key, extras=wanted)


def messages(inside: dict, sourced: bool) -> None:
    """msg_defs/ built by colcon and installed into .venv."""
    key = digest(ROOT / "msg_defs", ROOT / "requirements" / "ros-jazzy.txt", STAMPS / "environment")
    if stamped("messages", key):
        return
    if not sourced:
        mend(inside["include"])
    env = plain_environment()
    env["VIRTUAL_ENV"] = str(VENV)
    env["MAKEFLAGS"] = f"-j{os.cpu_count() or 1}"  # colcon's own choice waits while the machine is busy
    for name, folder in (
        ("PATH", "bin"),
        ("CMAKE_PREFIX_PATH", ""),
        ("AMENT_PREFIX_PATH", ""),
        ("LD_LIBRARY_PATH", "lib"),
    ):
        env[name] = os.pathsep.join(filter(None, [str(VENV / folder), env.get(name, "")]))
    scratch = VENV / "build"
    shutil.rmtree(scratch, ignore_errors=True)  # a half-finished build folder is not trusted
    run(
        "build the messages",
        [
            *(str(VENV / "bin" / "colcon"), "--log-base", str(scratch / "log"), "build", "--merge-install"),
            *("--build-base", str(scratch), "--install-base", str(VENV), "--base-paths", str(ROOT / "msg_defs")),
            *("--event-handlers", "console_direct+", "--cmake-args", "-DBUILD_TESTING=OFF"),
            *(f"-D{name}={VENV}/bin/python" for name in ("Python3_EXECUTABLE", "PYTHON_EXECUTABLE")),
        ],
        "correct what the compiler names; make distclean starts afresh",
        env,
    )
    load = "from wheelset_track_msgs.msg import ContactForces as C; C.__class__.__import_type_support__()"
    run("load the messages", [str(VENV / "bin" / "python"), "-c", load], "call make distclean, then again")
    stamp("messages", key)


def mend(include: str) -> None:
    """The wheels' CMake files name the Python and NumPy headers of the machine they were built on: name ours."""
    code = "import numpy; print(numpy.get_include())"
    numpy = subprocess.run([pip()[0], "-c", code], capture_output=True, text=True, check=True, env=plain_environment())
    for file in VENV.glob("share/*/cmake/*.cmake"):
        text = file.read_text()
        mended = re.sub(
            r"/opt/python/cp\w+-cp\w+/lib/python3\.\d+/site-packages/numpy/_?core/include", numpy.stdout.strip(), text
        )
        mended = re.sub(r"/opt/python/cp\w+-cp\w+/include/python3\.\d+", include, mended)
        if mended != text:
            file.write_text(mended)


def pip() -> list[str]:
    """The command that runs pip in .venv."""
    return [str(VENV / "bin" / "python"), "-m", "pip"]


def plain_environment() -> dict[str, str]:
    """The environment without what make and another environment's Python leave in it."""
    dropped = {"MAKEFLAGS", "MAKELEVEL", "MFLAGS", "PYTHONHOME", "VIRTUAL_ENV", "_ROS_WHEELS_BOOTSTRAP_COMPLETE"}
    return {name: value for name, value in os.environ.items() if name not in dropped}


def run(what: str, command: list[str], remedy: str, env: dict[str, str] | None = None) -> None:
    """Run a step with its output in the log; on failure show the end of the output, and raise."""
    start = time.monotonic()
    live = sys.stdout.isatty()
    print(f"setup: {what} ...", end="" if live else "\n", flush=True)
    with LOG.open("a+b") as log:
        log.write(f"\n$ {' '.join(command)}\n".encode())
        log.flush()
        begin = log.tell()
        process = subprocess.Popen(
            command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=env or plain_environment(), cwd=ROOT
        )
        while True:
            try:
                code = process.wait(1.0)
                break
            except subprocess.TimeoutExpired:
                if live:
                    print(f"\rsetup: {what} ... {time.monotonic() - start:.0f} s", end="", flush=True)
            except BaseException:
                process.terminate()
                process.wait()
                raise
        log.seek(begin)
        output = log.read().decode(errors="replace").splitlines()
    took = f"{time.monotonic() - start:.0f} s"
    print(f"\rsetup: {what} ... {took}" if live else f"setup: {what}: {took}", flush=True)
    if code != 0:
        print("\n".join(f"  | {line}" for line in output[-15:]), file=sys.stderr)
        raise SetupError(f"{what} failed: {remedy} (all output is in {LOG})")


def digest(*parts: object) -> str:
    """Digest of values, and of the content of files and folders."""
    hashed = hashlib.sha256()
    for part in parts:
        if isinstance(part, Path):
            for file in sorted(part.rglob("*")) if part.is_dir() else [part]:
                if file.is_file():
                    hashed.update(str(file.relative_to(ROOT)).encode() + b"\0" + file.read_bytes())
        else:
            hashed.update(repr(part).encode())
    return hashed.hexdigest()


def read_stamp(name: str) -> dict:
    """What a step left when it was done; empty if it never was."""
    try:
        return json.loads((STAMPS / name).read_text())
    except (OSError, ValueError):
        return {}


def stamped(name: str, key: str) -> bool:
    """Whether a step is done and nothing that it depends on has changed since."""
    return read_stamp(name).get("key") == key


def stamp(name: str, key: str, **more: object) -> None:
    """Note that a step is done."""
    STAMPS.mkdir(exist_ok=True)
    (STAMPS / name).write_text(json.dumps({"key": key, **more}))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
