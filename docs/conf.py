"""Site of the documentation: ``make docs`` builds it from the Markdown pages of the repository as they are.

The pages are written to be read in the repository too, so they contain nothing of Sphinx. The navigation is the list of
pages in ``index.md``: each of its sections becomes a part of the sidebar. Links to files that are no pages lead to the
repository if its address is known (WHEELSET_TRACK_SIM_REPOSITORY), and are plain text otherwise. Notebooks are shown
with the output that they hold; nothing is executed.
"""

import json
import os
import re
import sys
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from wheelset_track_sim.version import __version__  # noqa: E402  (the repository is not always installed)

REPOSITORY = os.environ.get("WHEELSET_TRACK_SIM_REPOSITORY", "").rstrip("/")
NOTEBOOKS = ROOT / "examples" / "notebooks"
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\((?!https?:|#)([^)#\s]*)(#[^)\s]*)?\)")

project = "wheelset_track_sim"
author = "wheelset_track_sim maintainers"
copyright = f"{author}, Apache License 2.0"  # noqa: A001  (its name in Sphinx)
version = release = __version__
extensions = ["myst_parser"]
root_doc = "docs/index"
source_suffix = {".md": "markdown", ".ipynb": "markdown"}
include_patterns = ["*.md", "docs/**.md", "examples/README.md", "examples/notebooks/*.ipynb"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = f"wheelset-track-sim {release}"  # it breaks at hyphens
highlight_language = "none"


def navigation(text: str) -> str:
    """Tables of contents of Sphinx, one for each section of the index with the pages that it links."""
    found = []
    for section in text.split("\n## ")[1:]:
        caption, _, body = section.partition("\n")
        pages = [page for _, page, _ in LINK.findall(body)]
        if "../examples/README.md" in pages:
            pages += [f"../{path.relative_to(ROOT)}" for path in sorted(NOTEBOOKS.glob("*.ipynb"))]
        found.append("\n".join([f"```{{toctree}}\n:hidden:\n:caption: {caption}\n", *pages, "```"]))
    return "\n\n".join(found)


def markdown(notebook: str) -> str:
    """A notebook as Markdown: its text, its code, what that printed, and its figures."""
    found = []
    for cell in json.loads(notebook)["cells"]:
        text = "".join(cell["source"])
        found.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", []):
            if "text" in output:
                found.append(f"```text\n{''.join(output['text'])}```")
            else:
                found.append(f"![figure](data:image/png;base64,{output['data']['image/png'].strip()})")
    return "\n\n".join(found) + "\n"


def prepared(app: Sphinx, page: str, source: list[str]) -> None:
    """Make links that leave the site absolute, or plain text, and add the navigation to the index."""
    folder = (ROOT / page).parent

    def outside(link: re.Match[str]) -> str:
        text, target, _ = link.groups()
        path = (folder / target).resolve().relative_to(ROOT)
        if path.with_suffix("").as_posix() in app.env.found_docs and path.suffix in source_suffix:
            return link[0]
        return f"[{text}]({REPOSITORY}/blob/HEAD/{path})" if REPOSITORY else text

    if app.env.doc2path(page).suffix == ".ipynb":
        source[0] = markdown(source[0])
    source[0] = LINK.sub(outside, source[0])
    if page == root_doc:
        source[0] += f"\n{navigation(source[0])}\n"


def entered(app: Sphinx, error: Exception | None) -> None:
    """Have the folder of the site open at the index."""
    if error is None:
        page = f'<!doctype html><title>{project}</title><meta http-equiv="refresh" content="0; url={root_doc}.html">\n'
        Path(app.outdir, "index.html").write_text(page, encoding="utf-8")


def setup(app: Sphinx) -> None:
    """Have each page prepared when it is read, and the site entered."""
    app.connect("source-read", prepared)
    app.connect("build-finished", entered)
