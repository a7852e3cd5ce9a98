"""The package as a whole: its layers, no circles of imports, one name for each public class."""

import ast
import re
import subprocess
import sys
from collections import defaultdict

from support.paths import ROOT
from wheelset_track_sim.runtime.sources import imports

PACKAGE = "wheelset_track_sim"
LAYERS = (
    *("version", "errors", "runtime", "inputs", "samples", "wheelset", "sensors", "track", "wayside"),
    *("irregularities", "contact"),
    *("scenario", "dynamics", "simulation", "fatigue", "verdict", "bags", "live", "twin", "identification"),
    *("monitoring", "report", "studies", "dataset", "ros", "explore", "cli"),
)
"""From low to high: a folder, or a module beside the folders, imports only from itself and from those before it."""


def modules():
    """Files of the package, by module."""
    found = {}
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = modules()


def imported(module):
    """Modules of the package that a module imports when it is executed, in functions too."""
    path = MODULES[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    return set(imports(path.read_bytes(), package, {PACKAGE: ROOT})) - {module}


def layer(module):
    """Number of the layer of a module; the package itself and its ``__main__`` are above all."""
    name = module.split(".")[1:2]
    return len(LAYERS) if name in ([], ["__main__"]) else LAYERS.index(name[0])


def circles(graph):
    """Groups of nodes that reach each other."""
    reached = {}
    for start in graph:
        found, waiting = set(), [start]
        while waiting:
            new = graph[waiting.pop()] - found
            found |= new
            waiting += new
        reached[start] = found
    groups = {frozenset({other for other in found if node in reached[other]}) for node, found in reached.items()}
    return sorted(sorted(group) for group in groups if group)


def public_classes():
    """Modules that define a public class, by its name."""
    found = defaultdict(list)
    for module, path in MODULES.items():
        for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(item, ast.ClassDef) and not item.name.startswith("_"):
                found[item.name].append(module)
    return found


def test_no_module_imports_upwards():
    upwards = {(module, other) for module in MODULES for other in imported(module) if layer(other) > layer(module)}
    assert upwards == set()


def test_no_modules_import_each_other():
    assert circles({module: imported(module) for module in MODULES}) == []


def test_circles_are_found():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set(), "e": {"e"}}
    assert circles(graph) == [["b", "c"], ["e"]]


def test_no_two_public_classes_have_one_name():
    assert {name: modules for name, modules in public_classes().items() if len(modules) > 1} == {}


def test_the_page_of_the_method_has_the_layers_in_their_order():
    text = (ROOT / "docs" / "theory" / "method.md").read_text(encoding="utf-8").partition("## Parts of the package")[2]
    named = [name for row in re.findall(r"^\| (`.*`) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)]
    assert named == [name for name in LAYERS if (ROOT / PACKAGE / name).is_dir()]


def test_importing_the_simulator_loads_only_what_every_run_needs():
    """SciPy loads ``scipy.signal`` and the like when they are first used; each of them takes a third of a second."""
    rarely = ["matplotlib", "mcap", "rosbags", "scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.stats"]
    code = f"import sys, {PACKAGE}.simulation.simulator; print(*[name for name in {rarely} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
