# SPDX-License-Identifier: Apache-2.0
"""For Sphinx: pages of the sources that pages link to, and the order of the pages.

A link to a file that is no page would be a download. Here it leads to the file's text,
highlighted; a link to a folder becomes its name.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_for_filename
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

FOLDER = "source"


class SourceLinks(SphinxTransform):
    """Downloads become links to pages of source."""

    default_priority = 300  # before the downloads are gathered

    def apply(self, **kwargs: Any) -> None:
        root = Path(self.app.srcdir)
        here = (root / self.env.doc2path(self.env.docname)).parent
        seen = self.env.__dict__.setdefault("source_pages", set())
        for node in list(self.document.findall(addnodes.download_reference)):
            path = root / node["reftarget"].lstrip("/")
            if not path.is_file():
                path = (here / node["reftarget"]).resolve()
            name = path.relative_to(root).as_posix()
            seen.add(name)
            up = "../" * (len(PurePosixPath(self.env.docname).parts) - 1)
            link = nodes.reference("", "", *node.children, refuri=f"{up}{FOLDER}/{name}.html")
            node.replace_self(link)


def pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """A page of each linked source."""
    formatter = HtmlFormatter(linenos=False, cssclass="highlight")
    for name in sorted(getattr(app.env, "source_pages", ())):
        path = Path(app.srcdir, name)
        text = path.read_text(encoding="utf-8")
        try:
            lexer = get_lexer_for_filename(name if path.suffix != ".vh" else "header.v")
            body = highlight(text, lexer, formatter)
        except ClassNotFound:
            body = highlight(text, get_lexer_for_filename("text.txt"), formatter)
        title = f"<h1>{name}</h1>"
        yield f"{FOLDER}/{name}", {"title": name, "body": title + body}, "page.html"


def folders(app: Sphinx, docname: str, source: list[str]) -> None:
    """Links to folders, which have no page, become plain text, and the first page lists all."""
    here = Path(app.srcdir, docname).parent

    def plain(found: re.Match[str]) -> str:
        return found[1] if (here / found[2]).is_dir() else found[0]

    source[0] = re.sub(r"(?<!!)\[([^\]]*)\]\(([^)#\s]+)\)", plain, source[0])
    if docname == app.config.root_doc:
        for caption, names in app.config.toctrees.items():
            entries = "\n".join(names)
            source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{entries}\n```\n"


def sidebar(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Beside a page are the branches that lead to it. The theme wants the whole tree: each of
    hundreds of modules in each of hundreds of pages, which takes most of a build's time."""
    if whole := context.get("toctree"):
        context["toctree"] = lambda **options: whole(**{**options, "collapse": True})


def breaks(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """In cells of tables names may break behind an underscore: on a narrow screen, not anywhere."""

    def cell(found: re.Match[str]) -> str:
        return re.sub(
            r'(?<=<span class="pre">)[^<]+', lambda name: name[0].replace("_", "_<wbr>"), found[0]
        )

    context["body"] = re.sub(r"<td\b.*?</td>", cell, context.get("body", ""), flags=re.DOTALL)


def index(app: Sphinx, exception: Exception | None) -> None:
    """The README is the front page under the name that a browser looks for."""
    if exception is None and app.builder.name == "html":
        shutil.copyfile(Path(app.outdir, "README.html"), Path(app.outdir, "index.html"))


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_config_value("toctrees", {}, "env", dict)
    app.add_transform(SourceLinks)
    app.connect("source-read", folders)
    app.connect("html-collect-pages", pages)
    app.connect("html-page-context", sidebar, priority=400)  # before the theme asks
    app.connect("html-page-context", breaks)
    app.connect("build-finished", index)
    return {"parallel_read_safe": False}
