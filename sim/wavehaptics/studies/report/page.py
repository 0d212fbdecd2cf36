# SPDX-License-Identifier: Apache-2.0
"""The report as one HTML file that needs no network: pictures and styles are inside."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from wavehaptics.runtime.repository import PACKAGE
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text

_NUMBER = re.compile(r"[–−+±]?[\d.,·⁰¹²³⁴⁵⁶⁷⁸⁹⁻]*( ?%)?|yes|no|–")
_WIDTH_PX = 960


def render(
    title: str, lead: Sequence[str], sections: Sequence[tuple[str, str, list[Block]]], footer: str
) -> str:
    """The page of ``sections``, each a name, a title and its blocks."""
    environment = Environment(
        loader=FileSystemLoader(PACKAGE / "studies" / "report"),
        autoescape=True,
        undefined=StrictUndefined,
    )
    shown = [
        {"name": name, "title": heading, "blocks": [_shown(block) for block in blocks]}
        for name, heading, blocks in sections
    ]
    return environment.get_template("page.html").render(
        title=title, lead=lead, sections=shown, footer=footer
    )


def _shown(block: Block) -> dict[str, Any]:
    if isinstance(block, Text):
        return {"kind": "Text", "text": block.text}
    if isinstance(block, Picture):
        data = base64.b64encode(block.path.read_bytes()).decode()
        source = f"data:image/png;base64,{data}"
        return {"kind": "Picture", "source": source, "caption": block.caption, "width": _WIDTH_PX}
    assert isinstance(block, Table)
    rows = [[str(cell) for cell in row] for row in block.rows]
    # A column with words in it is read from the left.
    words = [
        any(not _NUMBER.fullmatch(row[column]) for row in rows) for column in range(len(block.head))
    ]
    return {
        "kind": "Table", "caption": block.caption, "head": block.head, "rows": rows, "words": words,
    }  # fmt: skip
