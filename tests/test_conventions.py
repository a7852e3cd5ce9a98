"""Conventions of ROS: manifests by REP-149, messages with units by REP-103, what REP-2004 is claimed."""

import ast
import csv
import re
import sys
import xml.etree.ElementTree as ET
from configparser import ConfigParser

import pytest

from support.paths import ROOT

MANIFESTS = [ROOT / "package.xml", ROOT / "msg_defs" / "package.xml"]
DEFINITIONS = sorted([*(ROOT / "msg_defs").glob("*/*.msg"), *(ROOT / "msg_defs").glob("*/*.srv")])

DEPENDENCIES = {
    f"{kind}depend"
    for kind in ("", "build_", "build_export_", "buildtool_", "buildtool_export_", "exec_", "doc_", "test_")
} | {"conflict", "replace"}
SEQUENCE = [
    ({"name"}, 1, 1),
    ({"version"}, 1, 1),
    ({"description"}, 1, 1),
    ({"maintainer"}, 1, None),
    ({"license"}, 1, None),
    ({"url"}, 0, None),
    ({"author"}, 0, None),
    (DEPENDENCIES, 0, None),
    ({"group_depend"}, 0, None),
    ({"member_of_group"}, 0, None),
    ({"export"}, 0, 1),
]
"""Elements in the order of the schema of format 3: their names, how few, how many."""
PATTERNS = {
    "name": r"[a-z](_?[a-z0-9]+)*",
    "version": r"\d+\.\d+\.\d+",
    "description": r"(?s).{20,}",
    "maintainer": r".+",
    "license": r"Apache-2\.0",
}
with (ROOT / "tests" / "data" / "rosdep_keys.csv").open() as file:
    KEYS = {row["key"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}
"""What rosdep installs for each key, as it was looked up in rosdistro."""
UNITS = r"(N|Pa|m|s|rad|Hz|m/s|m/s\^2)"


@pytest.mark.parametrize("path", MANIFESTS, ids=["package", "messages"])
def test_manifest_is_of_format_3(path):
    root = ET.parse(path).getroot()
    assert (root.tag, root.get("format")) == ("package", "3")
    names = [item.tag for item in root]
    for kinds, fewest, most in SEQUENCE:
        count = next((i for i, name in enumerate(names) if name not in kinds), len(names))
        assert fewest <= count <= (most or count), f"{kinds}: {count}"
        names = names[count:]
    assert names == [], "unknown, or out of order"
    for item in root:
        if item.tag in PATTERNS:
            assert re.fullmatch(PATTERNS[item.tag], item.text), item.tag
    for maintainer in root.findall("maintainer"):
        assert re.fullmatch(r"[^@\s]+@[^@\s]+\.[^@\s]+", maintainer.get("email"))
    for kind in DEPENDENCIES:
        listed = [item.text for item in root.findall(kind)]
        assert len(listed) == len(set(listed)), f"{kind} names something twice"
    assert not {item.text for item in root.findall("depend")} & {item.text for item in root.findall("exec_depend")}
    [build_type] = root.findall("export/build_type")
    assert build_type.text in {"ament_python", "ament_cmake"}


@pytest.mark.parametrize("path", MANIFESTS, ids=["package", "messages"])
def test_manifest_is_read_without_a_warning(path):
    package = pytest.importorskip("catkin_pkg.package", reason="comes with the build tools of ROS: make setup")
    warnings = []
    package.parse_package(str(path), warnings=warnings).validate(warnings=warnings)
    assert warnings == []


def executed(tree):
    """Nodes of a module but what is for type checkers only."""
    for item in ast.iter_child_nodes(tree):
        if isinstance(item, ast.If) and isinstance(item.test, ast.Name) and item.test.id == "TYPE_CHECKING":
            continue
        yield item
        yield from executed(item)


def imported():
    """Top-level modules of others that what is installed imports."""
    found = set()
    for path in [
        *(ROOT / "wheelset_track_sim").rglob("*.py"),
        *(ROOT / "launch").glob("*.py"),
        ROOT / "tools" / "node",
    ]:
        for item in executed(ast.parse(path.read_text())):
            if isinstance(item, ast.Import):
                found |= {name.name.partition(".")[0] for name in item.names}
            elif isinstance(item, ast.ImportFrom) and item.level == 0:
                found.add(item.module.partition(".")[0])
    return found - set(sys.stdlib_module_names) - {"wheelset_track_sim"}


def test_keys_of_the_manifests_are_those_that_rosdep_resolves():
    named = {item.text for path in MANIFESTS for item in ET.parse(path).getroot() if item.tag in DEPENDENCIES}
    assert named - {ET.parse(path).getroot().findtext("name") for path in MANIFESTS} == set(KEYS)
    for key, row in KEYS.items():
        assert row["from"] in {"apt", "pip", "ros"}, key
        assert row["from"] != "ros" or row["installs"] == f"ros-jazzy-{key.replace('_', '-')}", key


@pytest.mark.slow
def test_every_import_has_its_dependency_and_every_dependency_is_imported():
    listed = {item.text for item in ET.parse(ROOT / "package.xml").getroot().findall("exec_depend")}
    config = ConfigParser()
    config.read(ROOT / "setup.cfg")
    extras = config["options.extras_require"]
    optional = set(
        re.findall(
            r"^[\w.-]+",
            "\n".join(extras[name] for name in ("prometheus", "report", "explore", "dask", "analysis", "completion")),
            re.M,
        )
    )
    provided = {module for key in listed - {"wheelset_track_msgs"} for module in KEYS[key]["imports"].split()}
    assert imported() - optional == provided | {"wheelset_track_msgs"}
    required = re.findall(r"^[\w-]+", config["options"]["install_requires"], re.MULTILINE)
    assert set(required) == {
        m for key in listed & set(KEYS) if KEYS[key]["from"] != "ros" for m in KEYS[key]["imports"].split()
    }


def fields(path):
    """Fields of a definition with their comments: type, name, comment."""
    for line in path.read_text().splitlines():
        declaration, _, comment = line.partition("#")
        if declaration.strip() and declaration.strip() != "---":
            kind, name = declaration.split(maxsplit=1)
            yield kind, name.strip(), comment.strip()


def test_messages_need_what_their_manifest_says():
    root = ET.parse(ROOT / "msg_defs" / "package.xml").getroot()
    used = {kind.partition("/")[0] for path in DEFINITIONS for kind, _, _ in fields(path) if "/" in kind}
    used |= {"builtin_interfaces"}  # of std_msgs/Header
    assert used == {item.text for item in root.findall("depend")}


@pytest.mark.parametrize("path", DEFINITIONS, ids=lambda path: path.name)
def test_definition_reads_well(path):
    text = path.read_text()
    assert text.startswith("# "), "what it is comes first"
    assert max(map(len, text.splitlines())) <= 120
    assert "\t" not in text
    for kind, name, comment in fields(path):
        if "=" in name and kind.startswith("uint"):
            continue  # a constant speaks for itself, or has a comment
        assert comment, f"{name} has no comment"
        if kind.startswith("float"):
            ratio = re.search(r"\b(over|likewise)\b", comment)
            assert ratio or re.search(rf"(^|[ ,(]){UNITS}($|[ ,;.)])", comment), f"{name} has no unit: {comment}"
        if kind == "std_msgs/Header":
            assert 'frame_id "track"' in comment
    columns = {line.index("#") for line in text.split("---")[0].splitlines() if re.match(r"\w.*#", line)}
    assert len(columns) <= 4, "comments are not aligned"


def test_quality_declaration_claims_what_holds():
    text = (ROOT / "QUALITY_DECLARATION.md").read_text()
    for link in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (ROOT / link).exists(), link
    level = int(re.search(r"\*\*Quality Level (\d)\*\*", text)[1])
    sources = [path for folder in ("wheelset_track_sim", "launch") for path in (ROOT / folder).rglob("*.py")]
    stated = all("Copyright" in path.read_text()[:300] for path in sources)
    assert level == (4 if stated else 5), "REP-2004, 3.ii of Level 4: a copyright statement in each source file"
    assert "QUALITY_DECLARATION.md" in (ROOT / "README.md").read_text()
