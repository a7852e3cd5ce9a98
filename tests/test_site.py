"""The site of the documentation: every page is in its navigation, and it builds without a warning."""

import subprocess
import sys

import pytest

from support.paths import ROOT


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_has_every_page(tmp_path):
    pytest.importorskip("furo", reason="the site needs the extra docs: make docs")
    command = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet", "--conf-dir", "docs"]
    done = subprocess.run([*command, ROOT, tmp_path], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    index = (tmp_path / "docs" / "index.html").read_text()
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    for page in pages:
        if page != ROOT / "docs" / "index.md":
            name = page.relative_to(ROOT).with_suffix(".html").as_posix()
            assert f'href="{name.removeprefix("docs/")}"' in index or f'href="../{name}"' in index, name
